#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/store/mesh_blob.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/fidentis_direct.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort::testing {

/// A plan run to its end by several runners, each with its own cache; the ready tasks are dealt out
/// in an order drawn from `seed`.
inline FinishedJob RunJobWithWorkers(const JobSpec& spec,
                                     const std::vector<SetMesh>& meshes,
                                     BlobStore& store,
                                     size_t workers,
                                     uint64_t seed) {
  std::vector<std::unique_ptr<MeshCache>> caches;
  std::vector<std::unique_ptr<TaskRunner>> runners;
  for (size_t i = 0; i < workers; ++i) {
    caches.push_back(std::make_unique<MeshCache>(store, 1 << 20));
    runners.push_back(std::make_unique<TaskRunner>(store, *caches.back()));
  }
  Random random(seed);
  FinishedJob job;
  job.plan = *JobPlan::Create(spec, meshes, {});
  size_t turn = 0;
  for (auto ready = job.plan->TakeReadyTasks(); !ready.empty();
       ready = job.plan->TakeReadyTasks()) {
    for (size_t left = ready.size(); left > 1; --left) {
      std::swap(ready[left - 1],
                ready[static_cast<size_t>(random.Below(static_cast<int64_t>(left)))]);
    }
    for (const Task& task : ready) {
      const absl::StatusOr<TaskResult> result = runners[turn++ % workers]->Run(task, {});
      job.status = result.ok() ? job.plan->TaskFinished(task.number, *result) : result.status();
      if (!job.status.ok()) {
        return job;
      }
    }
  }
  return job;
}

/// All metrics of every directed pair (source, target), from the job's tiles.
using PairMetrics = std::map<std::pair<int, int>, MetricValues>;
inline PairMetrics MetricsOfPairs(const FinishedJob& job, BlobStore& store) {
  PairMetrics pairs;
  for (const Digest& tile : job.plan->Outputs().tiles) {
    const auto blocks = *DecodeTileBlob(*store.Get(tile));
    for (const MetricBlock& block : blocks) {
      for (size_t place = 0; place < block.values.size(); ++place) {
        const std::pair<int, int> pair = {block.sources[place / block.targets.size()],
                                          block.targets[place % block.targets.size()]};
        EXPECT_TRUE(pairs.emplace(pair, block.values[place]).second) << "measured twice";
      }
    }
  }
  return pairs;
}

/// Equal as numbers that came from floats, NaN with NaN.
inline bool SameValue(double ours, float direct) {
  return std::isnan(direct)
             ? std::isnan(ours)
             : std::bit_cast<uint64_t>(ours) == std::bit_cast<uint64_t>(double{direct});
}

inline bool SameValues(const MetricValues& ours, const FidentisMetricValues& direct) {
  return std::equal(ours.begin(), ours.end(), direct.begin(), direct.end(), SameValue);
}

/// Everything that the job has given against the library called in one go.
inline void ExpectSame(const FinishedJob& job, BlobStore& store, const DirectFidentis& direct) {
  ASSERT_THAT(job.status, IsOk());
  ASSERT_TRUE(job.plan->Done());
  const size_t count = job.plan->Meshes().size();
  const PairMetrics pairs = MetricsOfPairs(job, store);
  ASSERT_EQ(pairs.size(), count * count);
  for (const auto& [pair, metrics] : pairs) {
    EXPECT_TRUE(SameValues(
        metrics, direct.Pair(static_cast<size_t>(pair.first), static_cast<size_t>(pair.second))))
        << pair.first << " " << pair.second;
  }
  const JobOutputs& outputs = job.plan->Outputs();
  EXPECT_EQ(DecodeMeshBlob(*store.Get(outputs.mean_shape))->vertices,
            direct.MeanShape().cast<double>());
  EXPECT_EQ(DecodeMeshBlob(*store.Get(outputs.variation_shape))->vertices,
            direct.Surface().cast<double>());
  const auto summary = DecodeSummaryBlob(*store.Get(outputs.summary));
  ASSERT_THAT(summary, IsOk());
  EXPECT_EQ(summary->mesh_count, static_cast<int64_t>(count));
  ASSERT_EQ(summary->values.size(), direct.Variation().size());
  for (size_t vertex = 0; vertex < summary->values.size(); ++vertex) {
    EXPECT_TRUE(SameValues(summary->values[vertex], direct.Variation()[vertex])) << vertex;
  }
  EXPECT_EQ(job.plan->TotalCounters().align.lookups, direct.AlignLookups());
  EXPECT_EQ(job.plan->TotalCounters().pairs, static_cast<int64_t>(count * count));
}

}  // namespace cohort::testing
