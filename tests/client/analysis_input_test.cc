#include "client/analysis_input.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

constexpr char kMatrix[] = "rms,a,b,c\na,0,1,2\nb,3,0,4\nc,2,4,0\n";
constexpr char kSymmetric[] = "rms,a,b,c\na,0,1,2\nb,1,0,4\nc,2,4,0\n";

class AnalysisInputTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    ASSERT_THAT(PrepareFolder(folder_), IsOk());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) {
    ASSERT_THAT(WriteWholeFile(folder_ / name, text), IsOk());
  }
  void WriteJob(const std::string& symmetrization, const std::string& sign) {
    Write("job.json",
          R"({"parameters": {"metric": "variance", "symmetrization": ")" + symmetrization +
              R"(", "compare": {"sign": ")" + sign +
              R"("}}, "meshes": [{"name": "a", "labels": {"person": "p"}, "status": "ok"},
                 {"name": "bad", "labels": {}, "status": "rejected", "reason": "empty"}]})");
  }
  [[nodiscard]] absl::StatusOr<AnalysisInput> Read(const std::string& name = "") const {
    return ReadAnalysisInput({.source = (folder_ / name).string(),
                              .server = {},
                              .metric = metric_,
                              .symmetrize = symmetrize_});
  }

  std::filesystem::path folder_;
  std::optional<Metric> metric_;
  std::optional<PairRule> symmetrize_;
};

TEST_F(AnalysisInputTest, ReadsAResultsFolder) {
  Write("matrix.csv", kSymmetric);
  Write("meshes.csv", "file,status,rms_residual\na,ok,0.25\nb,ok,NA\n");
  WriteJob("mean", "absolute");
  const auto input = Read();
  ASSERT_THAT(input, IsOk());
  EXPECT_EQ(input->metric, "variance");
  EXPECT_EQ(input->unit, "mm²");
  EXPECT_EQ(input->labels.at("a").at("person"), "p");
  EXPECT_THAT(input->rejected, ElementsAre("bad"));
  EXPECT_THAT(input->residuals, ElementsAre(::testing::Pair("a", 0.25)));
  EXPECT_TRUE(input->notes.empty());
}

TEST_F(AnalysisInputTest, TakesTheMeanOfADirectedJobAndSaysSo) {
  Write("matrix.csv", kMatrix);
  WriteJob("directed", "absolute");
  const auto mean = Read();
  ASSERT_THAT(mean, IsOk());
  EXPECT_EQ(mean->matrix.values(0, 1), 2);
  EXPECT_THAT(mean->notes, ElementsAre(HasSubstr("directed")));
  symmetrize_ = PairRule::kMax;
  const auto max = Read();
  ASSERT_THAT(max, IsOk());
  EXPECT_EQ(max->matrix.values(0, 1), 3);
  EXPECT_TRUE(max->notes.empty());
}

TEST_F(AnalysisInputTest, RefusesAFileThatIsNotSymmetric) {
  Write("m.csv", kMatrix);
  EXPECT_THAT(Read("m.csv"), StatusIs(absl::StatusCode::kInvalidArgument,
                                      "m.csv: the matrix is not symmetric: b, a is 3, a, b is 1"));
  symmetrize_ = PairRule::kMean;
  EXPECT_THAT(Read("m.csv"), IsOk());
}

TEST_F(AnalysisInputTest, RefusesWhatStatisticsCannotMeanAnything) {
  Write("matrix.csv", kSymmetric);
  WriteJob("mean", "signed");
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kFailedPrecondition, "signed"));
  WriteJob("mean", "absolute");
  metric_ = Metric::kRms;
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kFailedPrecondition, "holds variance, not rms"));
  EXPECT_THAT(Read("matrix.csv"),
              StatusIs(absl::StatusCode::kFailedPrecondition, "leave --metric out"));
  metric_.reset();
  Write("two.csv", ",a,b\na,0,1\nb,1,0\n");
  EXPECT_THAT(Read("two.csv"), StatusIs(absl::StatusCode::kInvalidArgument,
                                        "two.csv: the matrix has 2 meshes, at least 3"));
}

TEST_F(AnalysisInputTest, ReadsAFolderOfRemeasure) {
  Write("matrix.csv", kMatrix);
  Write("remeasure.json",
        R"({"metric": "p95", "unit": "mm", "symmetrization": "directed", "sign": "absolute"})");
  const auto input = Read();
  ASSERT_THAT(input, IsOk());
  EXPECT_EQ(input->metric, "p95");
  EXPECT_EQ(input->unit, "mm");
  EXPECT_EQ(input->matrix.values(0, 1), 2);
  Write("remeasure.json", R"({"metric": "p95", "symmetrization": "mean", "sign": "signed"})");
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kFailedPrecondition, "signed"));
}

TEST_F(AnalysisInputTest, NamesWhatIsWrongInAFolder) {
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kNotFound, "has no matrix.npy"));
  Write("matrix.csv", kSymmetric);
  Write("job.json", "{]");
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kInvalidArgument, "job.json: is not JSON"));
  Write("job.json", R"({"meshes": 1})");
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kInvalidArgument, "a mesh has no name"));
  Write("job.json", R"({"meshes": [], "parameters": {"metric": "new"}})");
  EXPECT_THAT(Read(), StatusIs(absl::StatusCode::kInvalidArgument, "metric is not known"));
  Write("job.json", R"({"method": "gpa", "parameters": {"size": "kept"}})");
  EXPECT_THAT(Read(), IsOk());
  EXPECT_THAT(Read("none"), StatusIs(absl::StatusCode::kNotFound, "no such folder"));
}

}  // namespace
}  // namespace cohort
