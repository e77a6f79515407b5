#include "common/jobs/job_spec.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;
using nlohmann::json;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

JobSpec UnusualSpec() {
  JobSpec spec;
  spec.method = Method::kEach;
  spec.base = "b \"quoted\".ply";
  spec.rounds = 7;
  spec.pose = PoseMode::kLandmarks;
  spec.landmarks = Sha256::Of("landmarks");
  spec.symmetric_copies = true;
  spec.icp.scale_mode = ScaleMode::kOff;
  spec.icp.max_iterations = 13;
  spec.icp.tolerance = 0.1 + 0.2;
  spec.mean_tolerance = 0.25;
  spec.icp.scale_limit = 1.5;
  spec.icp.rigid_first = false;
  spec.icp.acceleration = Acceleration::kNone;
  spec.icp.trimmed_share = 0.1;
  spec.icp.distance_limit = 7;
  spec.icp.boundary_pairs = BoundaryPairs::kReject;
  spec.undersampling = {.method = UndersamplingMethod::kRandom,
                        .count = 77,
                        .share = 0.5,
                        .radius = 2,
                        .seed = 0xFFFFFFFFFFFFFFF0u};
  spec.compare = {.correspondence = Correspondence::kSurface,
                  .boundary_pairs = BoundaryPairs::kKeep,
                  .retention = Retention::kCompact};
  spec.retention_budget = 12345678901;
  spec.metric = Metric::kPercentile75;
  spec.symmetrization = Symmetrization::kDirected;
  spec.neighbours = 5;
  spec.position_bits = 30;
  spec.size_ratio_limit = std::nextafter(3.0, 4.0);
  return spec;
}

TEST(JobSpecJson, RoundTripsThroughTextWithoutLosingABit) {
  const JobSpec expected = UnusualSpec();
  const auto spec = JobSpecFromJson(json::parse(ToJson(expected).dump()));
  ASSERT_THAT(spec, IsOk());
  EXPECT_EQ(ToJson(*spec), ToJson(expected));
  EXPECT_EQ(spec->compare, expected.compare);
  EXPECT_EQ(spec->undersampling.seed, expected.undersampling.seed);
  EXPECT_EQ(spec->icp.distance_limit, 7);
  EXPECT_EQ(spec->method, Method::kEach);
  EXPECT_EQ(spec->base, expected.base);
  EXPECT_EQ(spec->rounds, 7);
  EXPECT_EQ(spec->pose, PoseMode::kLandmarks);
  EXPECT_EQ(spec->landmarks, expected.landmarks);
  EXPECT_TRUE(spec->symmetric_copies);
  EXPECT_EQ(spec->icp.scale_mode, ScaleMode::kOff);
  EXPECT_EQ(spec->icp.max_iterations, 13);
  EXPECT_EQ(spec->icp.tolerance, 0.1 + 0.2);
  EXPECT_EQ(spec->metric, Metric::kPercentile75);
  EXPECT_EQ(spec->symmetrization, Symmetrization::kDirected);
  EXPECT_EQ(spec->neighbours, 5);
  EXPECT_EQ(spec->position_bits, 30);
  EXPECT_EQ(spec->size_ratio_limit, std::nextafter(3.0, 4.0));
}

TEST(JobSpecJson, TakesDefaultsForMissingFields) {
  const auto spec = JobSpecFromJson(json::parse(R"({"icp": {"max_iterations": 9}})"));
  ASSERT_THAT(spec, IsOk());
  json expected = ToJson(JobSpec());
  expected["icp"]["max_iterations"] = 9;
  EXPECT_EQ(ToJson(*spec), expected);
}

struct BadSpec {
  std::string text;
  std::string message;
};
class BadSpecJson : public ::testing::TestWithParam<BadSpec> {};

TEST_P(BadSpecJson, IsRefusedByField) {
  EXPECT_THAT(JobSpecFromJson(json::parse(GetParam().text)),
              StatusIs(kInvalid, GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Table,
    BadSpecJson,
    ::testing::Values(
        BadSpec{"[]", "job spec: expected an object, not []"},
        BadSpec{R"({"method": "all"})", "job spec.method: unknown name \"all\""},
        BadSpec{R"({"method": 3})", "job spec.method: expected a string, not 3"},
        BadSpec{R"({"rounds": 2.5})", "job spec.rounds: expected an integer, not 2.5"},
        BadSpec{R"({"rounds": 9999999999})", "job spec.rounds: expected an integer from"},
        BadSpec{R"({"rounds": 18446744073709551615})", "job spec.rounds: expected an integer from"},
        BadSpec{R"({"base": null})", "job spec.base: expected a string, not null"},
        BadSpec{R"({"icp": 1})", "job spec.icp: expected an object, not 1"},
        BadSpec{R"({"icp": {"tolerance": "x"}})", "job spec.icp.tolerance: expected a number"},
        BadSpec{R"({"icp": {"scale": "half"}})", "job spec.icp.scale: unknown name"},
        BadSpec{R"({"metric": "p76"})", "job spec.metric: unknown name"},
        BadSpec{R"({"round": 3})", "job spec.round: unknown field"}));

TEST(JobSpec, DefaultsAndPresetsAreValid) {
  EXPECT_THAT(JobSpec().Validate(), IsOk());
  EXPECT_THAT(UnusualSpec().Validate(), IsOk());
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach, Method::kNone}) {
    EXPECT_THAT(PresetSpec("default", method)->Validate(), IsOk());
    EXPECT_THAT(PresetSpec("thesis", method)->Validate(), IsOk());
    EXPECT_EQ(PresetSpec("thesis", method)->method, method);
    EXPECT_EQ(PresetSpec("fidentis", method)->method, method);
  }
}

struct BadValue {
  std::string message;
  void (*change)(JobSpec&);
};
class BadSpecValue : public ::testing::TestWithParam<BadValue> {};

TEST_P(BadSpecValue, IsRefusedByFieldAndValue) {
  JobSpec spec;
  GetParam().change(spec);
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Table,
    BadSpecValue,
    ::testing::Values(
        BadValue{"rounds is 0, expected 1 to 100", [](JobSpec& spec) { spec.rounds = 0; }},
        BadValue{"rounds is 101", [](JobSpec& spec) { spec.rounds = 101; }},
        BadValue{"neighbours is 0, expected at least 1",
                 [](JobSpec& spec) { spec.neighbours = 0; }},
        BadValue{"position_bits is 7, expected 8 to 30",
                 [](JobSpec& spec) { spec.position_bits = 7; }},
        BadValue{"position_bits is 31", [](JobSpec& spec) { spec.position_bits = 31; }},
        BadValue{"landmarks is empty, expected a blob with the pose",
                 [](JobSpec& spec) { spec.pose = PoseMode::kLandmarks; }},
        BadValue{"landmarks is a blob, expected a blob with the pose",
                 [](JobSpec& spec) { spec.landmarks = Sha256::Of("x"); }},
        BadValue{"pose is \"landmarks\", expected another with the method",
                 [](JobSpec& spec) {
                   spec.pose = PoseMode::kLandmarks;
                   spec.landmarks = Sha256::Of("x");
                   spec.method = Method::kNone;
                 }},
        BadValue{"size_ratio_limit is 1, expected 0 (not checked) or more than 1",
                 [](JobSpec& spec) { spec.size_ratio_limit = 1; }},
        BadValue{"size_ratio_limit is -5", [](JobSpec& spec) { spec.size_ratio_limit = -5; }},
        BadValue{"size_ratio_limit is nan",
                 [](JobSpec& spec) {
                   spec.size_ratio_limit = std::numeric_limits<double>::quiet_NaN();
                 }},
        BadValue{"base is \"a.ply\", expected none with the base rule \"auto\"",
                 [](JobSpec& spec) {
                   spec.base_rule = BaseRule::kAuto;
                   spec.base = "a.ply";
                 }},
        BadValue{"compare.boundary_pairs is \"reject\"",
                 [](JobSpec& spec) {
                   spec.compare.correspondence = Correspondence::kSurface;
                   spec.compare.boundary_pairs = BoundaryPairs::kReject;
                 }},
        BadValue{"icp: ICP: boundary pairs",
                 [](JobSpec& spec) {
                   spec.icp.correspondence = Correspondence::kSurface;
                   spec.icp.boundary_pairs = BoundaryPairs::kReject;
                 }},
        BadValue{"mean_tolerance is -1", [](JobSpec& spec) { spec.mean_tolerance = -1; }},
        BadValue{"retention_budget is -1", [](JobSpec& spec) { spec.retention_budget = -1; }},
        BadValue{"undersampling",
                 [](JobSpec& spec) { spec.undersampling.method = UndersamplingMethod::kDisk; }},
        BadValue{"icp", [](JobSpec& spec) { spec.icp.max_iterations = 0; }}));

TEST(PresetSpec, ThesisHasTheTextsNumbers) {
  const auto average = PresetSpec("thesis", Method::kAverage);
  ASSERT_THAT(average, IsOk());
  EXPECT_EQ(average->icp.max_iterations, 10);
  EXPECT_EQ(average->icp.tolerance, 0.05);
  EXPECT_EQ(average->icp.scale_mode, ScaleMode::kFree);
  EXPECT_EQ(average->rounds, 3);
  EXPECT_EQ(PresetSpec("thesis", Method::kOne)->icp.max_iterations, 40);
  EXPECT_EQ(PresetSpec("thesis", Method::kEach)->icp.max_iterations, 40);
}

TEST(PresetSpec, ListsThePresetsWhenThereIsNoSuch) {
  EXPECT_THAT(PresetSpec("fast", Method::kOne),
              StatusIs(kInvalid, "expected default, thesis or fidentis"));
}

TEST(JobSpecNames, AreTheInverseOfEachOther) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach, Method::kNone}) {
    EXPECT_EQ(MethodFromName(MethodName(method)), method);
  }
  for (const PoseMode pose : {PoseMode::kPrincipalAxes, PoseMode::kNone, PoseMode::kLandmarks}) {
    EXPECT_EQ(PoseModeFromName(PoseModeName(pose)), pose);
  }
  for (const Symmetrization value :
       {Symmetrization::kMean, Symmetrization::kMax, Symmetrization::kDirected}) {
    EXPECT_EQ(SymmetrizationFromName(SymmetrizationName(value)), value);
  }
  EXPECT_EQ(MethodFromName("Average"), std::nullopt);
}

}  // namespace
}  // namespace cohort
