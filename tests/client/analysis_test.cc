#include "client/analysis.h"

#include <cmath>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/analysis_meshes.h"
#include "client/files.h"
#include "client/output/analysis_text.h"
#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The reference matrix with its labels, and sessions by turns.
AnalysisInput Reference() {
  AnalysisInput input;
  input.source = "reference";
  input.matrix = ReferenceMatrix("a");
  input.metric = "rms";
  input.unit = "mm";
  const std::vector<std::string> persons = ReferenceLabels(1);
  const std::vector<std::string> groups = ReferenceLabels(2);
  for (size_t i = 0; i < persons.size(); ++i) {
    const std::string& mesh = input.matrix.labels[i];
    input.labels[mesh] = {
        {"person", persons[i]}, {"group", groups[i]}, {"session", i < 6 ? "first" : "second"}};
    input.residuals[mesh] = i == 3 ? 9 : 1 + 0.01 * static_cast<double>(i);
  }
  return input;
}

absl::StatusOr<Analysis> Analyzed(const AnalysisInput& input, const AnalysisOptions& options) {
  SerialExecutor executor;
  return AnalyzeMatrix(input, options, executor);
}

TEST(AnalyzeMatrix, AnswersEverythingThatLabelsAllow) {
  const auto analysis =
      Analyzed(Reference(), {.neighbours = 2, .clusters = 3, .by = "group", .permutations = 99});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_EQ(analysis->neighbours[0].size(), 2U);
  EXPECT_EQ(analysis->complete.labels.size(), 16U);
  EXPECT_EQ(analysis->clusters.size(), 16U);
  ASSERT_TRUE(analysis->permanova && analysis->groups);
  EXPECT_NEAR(analysis->permanova->f, ReferenceValues("r.txt")["permanova_group"][4], 1e-10);
  ASSERT_TRUE(analysis->identification && analysis->other_sessions);
  EXPECT_EQ(analysis->identification->identification.ShareAtRank(1), 0.4375);
  EXPECT_LT(analysis->other_sessions->scores.impostor.size(),
            analysis->identification->scores.impostor.size());
  EXPECT_TRUE(analysis->outliers.IsOutlier(3)) << "its residual is 9";
  EXPECT_TRUE(analysis->notes.empty());
}

TEST(AnalyzeMatrix, NamesTheOptionThatIsWrong) {
  EXPECT_THAT(Analyzed(Reference(), {.neighbours = -1}), StatusIs(kInvalid, "--neighbours -1"));
  EXPECT_THAT(Analyzed(Reference(), {.axes = 0}), StatusIs(kInvalid, "--axes 0"));
  EXPECT_THAT(Analyzed(Reference(), {.clusters = 17}), StatusIs(kInvalid, "--clusters 17"));
  EXPECT_THAT(Analyzed(Reference(), {.permutations = 0}), StatusIs(kInvalid, "permutations: 0"));
}

TEST(AnalyzeMatrix, NamesTheLabelsThatAreWrong) {
  EXPECT_THAT(Analyzed(Reference(), {.by = "sex"}),
              StatusIs(kInvalid, "column 'sex'; there are: group, person, session"));
  AnalysisInput one = Reference();
  for (auto& [mesh, labels] : one.labels) {
    labels["group"] = "north";
  }
  EXPECT_THAT(Analyzed(one, {.by = "group"}),
              StatusIs(kInvalid, "reference: groups by group: all meshes are of one group, north"));
  EXPECT_THAT(Analyzed(Reference(), {.person = "who"}), StatusIs(kInvalid, "column 'who'"));
  EXPECT_THAT(Analyzed(Reference(), {.session = "day"}), StatusIs(kInvalid, "column 'day'"));
  AnalysisInput none = Reference();
  none.labels.clear();
  EXPECT_THAT(Analyzed(none, {.by = "sex"}), StatusIs(kInvalid, "or any other (--labels"));
}

TEST(AnalyzeMatrix, NotesWhyNobodyIsIdentified) {
  AnalysisInput input = Reference();
  for (auto& [mesh, labels] : input.labels) {
    labels["person"] = mesh;
  }
  const auto analysis = Analyzed(input, {});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_FALSE(analysis->identification);
  EXPECT_THAT(analysis->notes, ElementsAre(HasSubstr("no person has two meshes")));
}

TEST(AnalyzeMatrix, GoesOnWithoutMeshesOfMissingPairs) {
  AnalysisInput input = Reference();
  for (const Eigen::Index other : {0, 1, 2}) {
    input.matrix.values(5, other) = input.matrix.values(other, 5) = kNaN;
  }
  const auto analysis = Analyzed(input, {.by = "group", .permutations = 9});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_THAT(analysis->incomplete, ElementsAre("m05.ply"));
  EXPECT_EQ(analysis->permanova->meshes, 15);
  EXPECT_EQ(analysis->neighbours.size(), 16U);
  EXPECT_EQ(analysis->identification->scores.missing, 3);
  EXPECT_THAT(analysis->notes, ElementsAre(HasSubstr("without m05.ply, which has missing")));
}

TEST(AnalyzeMatrix, RefusesWhatIsNoDistanceMatrix) {
  AnalysisInput input = Reference();
  input.matrix.values(4, 4) = 1;
  EXPECT_THAT(Analyzed(input, {}), StatusIs(kInvalid, "reference: the distance of m04.ply"));
  input.matrix.values.setConstant(kNaN);
  EXPECT_THAT(Analyzed(input, {}), StatusIs(kInvalid, "meshes have values with all others"));
}

TEST(AnalysisToText, SaysWhatPeopleAskFirst) {
  const AnalysisInput input = Reference();
  const AnalysisOptions options{.by = "group", .threshold = 2.5, .permutations = 99};
  const auto analysis = Analyzed(input, options);
  ASSERT_THAT(analysis, IsOk());
  const std::string text = AnalysisToText(input, options, *analysis);
  EXPECT_THAT(text, HasSubstr("reference: 16 meshes, rms\n"));
  EXPECT_THAT(text, HasSubstr("average linkage, 15 merges from 0.702 mm"));
  EXPECT_THAT(text, HasSubstr("F = 7.12, R2 = 0.337"));
  EXPECT_THAT(text, HasSubstr("m03.ply"));
  EXPECT_THAT(text, HasSubstr("rank 1: 43.8 % of 16 searches"));
  EXPECT_THAT(text, HasSubstr("EER 28.3 %"));
  EXPECT_THAT(text, HasSubstr("at 2.50 mm: FAR"));
  EXPECT_THAT(text, HasSubstr("other sessions:"));
}

TEST(AnalysisToJson, HasNullForWhatIsNotThere) {
  AnalysisInput input = Reference();
  input.labels.clear();
  input.metric.clear();
  const auto analysis = Analyzed(input, {});
  ASSERT_THAT(analysis, IsOk());
  const nlohmann::ordered_json json = AnalysisToJson(input, {}, *analysis);
  EXPECT_TRUE(json["metric"].is_null());
  EXPECT_TRUE(json["groups"].is_null());
  EXPECT_TRUE(json["identification"].is_null());
  EXPECT_EQ(json["clusters"]["merges"], 15);
}

TEST(MatchMeshes, BringsMatricesToOneOrder) {
  std::vector<AnalysisInput> inputs = {Reference(), Reference()};
  std::vector<int64_t> reversed;
  for (int64_t row = 15; row >= 0; --row) {
    reversed.push_back(row);
  }
  const MetricMatrix& first = inputs[0].matrix;
  inputs[1].matrix.values = first.values(reversed, reversed).eval();
  std::reverse(inputs[1].matrix.labels.begin(), inputs[1].matrix.labels.end());
  ASSERT_THAT(MatchMeshes(inputs, OtherMeshes::kRefuse), IsOk());
  EXPECT_EQ(inputs[1].matrix.labels, first.labels);
  EXPECT_EQ(inputs[1].matrix.values, first.values);
}

TEST(MatchMeshes, NamesMeshesOfOneMatrixOnly) {
  std::vector<AnalysisInput> inputs = {Reference(), Reference()};
  inputs[1].source = "other";
  inputs[1].matrix.labels[2] = "new.ply";
  EXPECT_THAT(MatchMeshes(inputs, OtherMeshes::kRefuse),
              StatusIs(kInvalid, "1 mesh of reference is not in other: m02.ply; --common"));
  ASSERT_THAT(MatchMeshes(inputs, OtherMeshes::kLeaveOut), IsOk());
  EXPECT_EQ(inputs[0].matrix.labels.size(), 15U);
  EXPECT_EQ(inputs[0].matrix.labels, inputs[1].matrix.labels);
  for (std::string& label : inputs[1].matrix.labels) {
    label += "x";
  }
  EXPECT_THAT(MatchMeshes(inputs, OtherMeshes::kLeaveOut),
              StatusIs(kInvalid, "0 meshes are in all of the matrices"));
}

TEST(ReplaceLabels, GoesBeforeTheLabelsOfTheJob) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "cohort_analysis_labels.csv";
  ASSERT_THAT(WriteWholeFile(file, "file,group\nm00.ply,east\nm01.ply,NA\n"), IsOk());
  AnalysisInput input = Reference();
  ASSERT_THAT(ReplaceLabels(file.string(), input), IsOk());
  const auto groups = LabelColumn(input, "group");
  ASSERT_THAT(groups, IsOk());
  EXPECT_EQ(groups->at(0), "east");
  EXPECT_EQ(groups->at(1), "");
  EXPECT_EQ(groups->at(2), "north");
  EXPECT_THAT(input.notes, ElementsAre(HasSubstr("14 of 16 meshes are not in")));
  ASSERT_THAT(WriteWholeFile(file, "file,group\nother.ply,east\n"), IsOk());
  EXPECT_THAT(ReplaceLabels(file.string(), input), StatusIs(kInvalid, "(such as other.ply)"));
  std::filesystem::remove(file);
}

TEST(LabelByName, TakesLabelsFromTheNames) {
  AnalysisInput input = Reference();
  ASSERT_THAT(LabelByName("m{tens}5", input), IsOk());
  EXPECT_EQ(input.labels["m15.ply"]["tens"], "1");
  EXPECT_EQ(input.labels["m15.ply"]["group"], "north") << "others stay";
  EXPECT_THAT(input.notes, ElementsAre(HasSubstr("m00.ply, m01.ply")));
  EXPECT_THAT(LabelByName("{a}_{b}", input), StatusIs(kInvalid, "(such as m00.ply)"));
}

}  // namespace
}  // namespace cohort
