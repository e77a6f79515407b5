#include "common/jobs/worker_build.h"

#include <string>

#include <gmock/gmock.h>

#include "common/base/version.h"
#include "common/jobs/action_key.h"

namespace cohort {
namespace {

TEST(WorkerBuild, TellsBuildsOfOneReleaseApartByTheirResults) {
  EXPECT_THAT(WorkerBuild(), ::testing::StartsWith(std::string(BuildVersion()) + " "));
  EXPECT_THAT(WorkerBuild(), ::testing::HasSubstr("results " + std::to_string(kResultsVersion)));
}

}  // namespace
}  // namespace cohort
