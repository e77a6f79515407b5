#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "common/jobs/blobs.h"
#include "common/store/blob_store.h"
#include "server/planning/job_plan.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort::testing {

enum class Order { kForward, kBackward };

/// A plan run to its end by one runner.
struct FinishedJob {
  std::unique_ptr<JobPlan> plan;
  absl::Status status;
};

inline FinishedJob RunJob(const JobSpec& spec,
                          const std::vector<SetMesh>& meshes,
                          BlobStore& store,
                          Order order = Order::kForward) {
  MeshCache cache(store, 1 << 20);
  TaskRunner runner(store, cache);
  FinishedJob job;
  job.plan = *JobPlan::Create(spec, meshes, {});
  std::vector<Task> ready = job.plan->TakeReadyTasks();
  while (!ready.empty() && job.status.ok()) {
    if (order == Order::kBackward) {
      std::reverse(ready.begin(), ready.end());
    }
    for (const Task& task : ready) {
      const absl::StatusOr<TaskResult> result = runner.Run(task, {});
      job.status = result.ok() ? job.plan->TaskFinished(task.number, *result) : result.status();
      if (!job.status.ok()) {
        return job;
      }
    }
    ready = job.plan->TakeReadyTasks();
  }
  return job;
}

inline JobSpec QuickSpec(Method method) {
  JobSpec spec;
  spec.method = method;
  spec.rounds = 2;
  spec.icp.max_iterations = 4;
  spec.icp.tolerance = 0;
  return spec;
}

/// RMS of the directed pair, from the job's tiles.
inline std::map<std::pair<int, int>, double> RmsOfPairs(const FinishedJob& job, BlobStore& store) {
  std::map<std::pair<int, int>, double> pairs;
  for (const Digest& tile : job.plan->Outputs().tiles) {
    const auto blocks = *DecodeTileBlob(*store.Get(tile));
    for (const MetricBlock& block : blocks) {
      for (size_t r = 0; r < block.sources.size(); ++r) {
        for (size_t c = 0; c < block.targets.size(); ++c) {
          pairs[{block.sources[r], block.targets[c]}] =
              block.values[r * block.targets.size() + c][0];
        }
      }
    }
  }
  return pairs;
}

}  // namespace cohort::testing
