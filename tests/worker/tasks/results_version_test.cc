#include <string>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "common/jobs/action_key.h"
#include "common/jobs/fidentis_spec.h"
#include "common/store/memory_blob_store.h"
#include "tests/testing/demo_scans.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort {
namespace {

/// Names everything that a small job writes.
std::string OutputsOf(const JobSpec& spec) {
  MemoryBlobStore store;
  const auto job = testing::RunJob(spec, testing::PutDemoScans(store, 3, 1), store);
  EXPECT_TRUE(job.status.ok()) << job.status;
  const JobOutputs& outputs = job.plan->Outputs();
  std::string names = absl::StrCat(outputs.mean_shape.Hex(), outputs.summary.Hex());
  for (const auto* blobs : {&outputs.tiles, &outputs.alignments, &outputs.fields, &outputs.poses,
                            &outputs.preview, &outputs.signatures}) {
    for (const Digest& blob : *blobs) {
      names += blob.Hex();
    }
  }
  return Sha256::Of(names).Hex().substr(0, 16);
}

// If this fails, results are other bytes than before. If that is meant to be so, add one to
// kResultsVersion (common/jobs/action_key.h), so that results of earlier builds are not mixed with
// new ones, and write the new names here.
TEST(ResultsVersion, GrowsWheneverTheBytesOfResultsChange) {
  EXPECT_EQ(kResultsVersion, 4);
  JobSpec average = testing::QuickSpec(Method::kAverage);
  average.preview = true;
  average.compare.retention = Retention::kVectors;
  EXPECT_EQ(OutputsOf(average), "4a2bc5422485cdc4");
  JobSpec one = testing::QuickSpec(Method::kOne);
  one.compare.retention = Retention::kSketch;
  one.icp.correspondence = Correspondence::kSurface;
  one.compare.correspondence = Correspondence::kSurface;
  EXPECT_EQ(OutputsOf(one), "71bd3ef9621e294f");
  JobSpec each = testing::QuickSpec(Method::kEach);
  each.compare.retention = Retention::kCompact;
  EXPECT_EQ(OutputsOf(each), "38110ddec66691ee");
  EXPECT_EQ(OutputsOf(FidentisSpec(Method::kAverage)), "3c112cf13a605ca3");
}

}  // namespace
}  // namespace cohort
