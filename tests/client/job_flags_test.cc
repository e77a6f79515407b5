#include "client/job_flags.h"

#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

/// The flags as a command takes them, with a folder behind the options.
absl::StatusOr<JobSpec> Parse(std::vector<std::string> arguments) {
  CLI::App app;
  std::string folder;
  JobFlags flags;
  app.add_option("folder", folder)->required();
  flags.AddTo(app);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  app.parse(reversed);
  EXPECT_EQ(folder, "scans");
  return flags.ToSpec();
}

TEST(JobFlags, TakeLandmarksAsThePose) {
  const auto spec = Parse({"--landmarks", "a.csv", "--landmarks", "b/", "scans"});
  ASSERT_THAT(spec, IsOk());
  EXPECT_EQ(spec->pose, PoseMode::kLandmarks);
  EXPECT_TRUE(spec->landmarks.empty()) << "they are read when the meshes are known";
  EXPECT_THAT(Parse({"--pose", "landmarks", "--landmarks", "a.csv", "scans"}), IsOk());
}

TEST(JobFlags, RefuseLandmarksThatContradict) {
  EXPECT_THAT(Parse({"--pose", "landmarks", "scans"}),
              StatusIs(kInvalid, "--landmarks FILE_OR_FOLDER is needed"));
  EXPECT_THAT(Parse({"--pose", "none", "--landmarks", "a.csv", "scans"}),
              StatusIs(kInvalid, "--pose none: with --landmarks"));
  EXPECT_THAT(Parse({"--method", "none", "--landmarks", "a.csv", "scans"}),
              StatusIs(kInvalid, "--method none moves no mesh"));
  EXPECT_THAT(Parse({"--pose", "upright", "scans"}),
              StatusIs(kInvalid, "expected principal-axes, landmarks or none"));
  EXPECT_THAT(Parse({"--landmarks", "a.csv", "--rounds", "0", "scans"}),
              StatusIs(kInvalid, "rounds is 0"));
}

TEST(JobFlags, TellSymmetricCopiesFromTheSymmetryOfTheMatrix) {
  const auto spec = Parse({"--symmetric-copies", "--symmetrize", "max", "scans"});
  ASSERT_THAT(spec, IsOk());
  EXPECT_TRUE(spec->symmetric_copies);
  EXPECT_EQ(spec->symmetrization, Symmetrization::kMax);
  EXPECT_FALSE(Parse({"scans"})->symmetric_copies);
}

}  // namespace
}  // namespace cohort
