#include "common/jobs/fidentis_spec.h"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

TEST(FidentisSpec, HasTheNumbersOfTheGoldenStudies) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach}) {
    const auto spec = PresetSpec("fidentis", method);
    ASSERT_THAT(spec, IsOk());
    EXPECT_THAT(spec->Validate(), IsOk());
    EXPECT_EQ(spec->arithmetic, Arithmetic::kFidentis);
    EXPECT_EQ(spec->method, method);
    EXPECT_EQ(spec->icp.max_iterations, method == Method::kAverage ? 10 : 40);
    EXPECT_EQ(spec->icp.tolerance, 0.05);
    EXPECT_EQ(spec->icp.scale_mode, ScaleMode::kFromX);
    EXPECT_EQ(spec->rounds, 3);
    EXPECT_EQ(spec->pose, PoseMode::kNone);
    EXPECT_EQ(spec->position_bits, 0);
  }
}

TEST(FidentisSpec, SurvivesJson) {
  JobSpec spec = FidentisSpec(Method::kOne);
  spec.compare.sign = DistanceSign::kSigned;
  const nlohmann::json json = ToJson(spec);
  EXPECT_EQ(json["arithmetic"], "fidentis");
  EXPECT_EQ(json["icp"]["scale"], "from-x");
  EXPECT_EQ(json["compare"]["sign"], "signed");
  const auto back = JobSpecFromJson(json);
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(ToJson(*back), json);
}

TEST(FidentisSpec, TakesWhatThePredecessorTakes) {
  JobSpec spec = FidentisSpec(Method::kAverage);
  spec.base = "b.obj";
  spec.rounds = 5;
  spec.icp.scale_mode = ScaleMode::kOff;
  spec.icp.max_iterations = 15;
  spec.icp.tolerance = 0;
  spec.compare.sign = DistanceSign::kSigned;
  spec.compare.retention = Retention::kMetrics;
  spec.symmetrization = Symmetrization::kDirected;
  EXPECT_THAT(spec.Validate(), IsOk());
}

struct BadValue {
  std::string message;
  void (*change)(JobSpec&);
};
class WhatThePredecessorLacks : public ::testing::TestWithParam<BadValue> {};

TEST_P(WhatThePredecessorLacks, IsRefusedByFieldAndValue) {
  JobSpec spec = FidentisSpec(Method::kAverage);
  GetParam().change(spec);
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, GetParam().message));
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, "in the preset fidentis"));
}

INSTANTIATE_TEST_SUITE_P(
    Table,
    WhatThePredecessorLacks,
    ::testing::Values(
        BadValue{"method is \"none\", expected average, one or each",
                 [](JobSpec& spec) { spec.method = Method::kNone; }},
        BadValue{"base_rule is \"auto\"", [](JobSpec& spec) { spec.base_rule = BaseRule::kAuto; }},
        BadValue{"mean_tolerance is 0.5", [](JobSpec& spec) { spec.mean_tolerance = 0.5; }},
        BadValue{"preview is true", [](JobSpec& spec) { spec.preview = true; }},
        BadValue{"symmetric_copies is true", [](JobSpec& spec) { spec.symmetric_copies = true; }},
        BadValue{"pose is \"principal-axes\"",
                 [](JobSpec& spec) { spec.pose = PoseMode::kPrincipalAxes; }},
        BadValue{"undersampling.method is \"random\"",
                 [](JobSpec& spec) { spec.undersampling.method = UndersamplingMethod::kRandom; }},
        BadValue{"position_bits is 18, expected 0 (as in the file)",
                 [](JobSpec& spec) { spec.position_bits = 18; }},
        BadValue{"icp.scale is \"least-squares\", expected \"from-x\" (on) or \"off\"",
                 [](JobSpec& spec) { spec.icp.scale_mode = ScaleMode::kFree; }},
        BadValue{"icp.max_iterations is 0", [](JobSpec& spec) { spec.icp.max_iterations = 0; }},
        BadValue{"icp.tolerance is -1", [](JobSpec& spec) { spec.icp.tolerance = -1; }},
        BadValue{
            "icp.tolerance is inf",
            [](JobSpec& spec) { spec.icp.tolerance = std::numeric_limits<double>::infinity(); }},
        BadValue{"icp.scale_limit is 2", [](JobSpec& spec) { spec.icp.scale_limit = 2; }},
        BadValue{"icp.rigid_first is true", [](JobSpec& spec) { spec.icp.rigid_first = true; }},
        BadValue{"icp.acceleration is \"anderson\"",
                 [](JobSpec& spec) { spec.icp.acceleration = Acceleration::kAnderson; }},
        BadValue{"icp.trimmed_share is 0.1", [](JobSpec& spec) { spec.icp.trimmed_share = 0.1; }},
        BadValue{"icp.distance_limit is 3", [](JobSpec& spec) { spec.icp.distance_limit = 3; }},
        BadValue{"icp.boundary_pairs is \"reject\"",
                 [](JobSpec& spec) { spec.icp.boundary_pairs = BoundaryPairs::kReject; }},
        BadValue{"icp.correspondence is \"surface\"",
                 [](JobSpec& spec) { spec.icp.correspondence = Correspondence::kSurface; }},
        BadValue{"compare.correspondence is \"surface\"",
                 [](JobSpec& spec) { spec.compare.correspondence = Correspondence::kSurface; }},
        BadValue{"compare.boundary_pairs is \"reject\"",
                 [](JobSpec& spec) { spec.compare.boundary_pairs = BoundaryPairs::kReject; }},
        BadValue{"compare.retention is \"sketch\"",
                 [](JobSpec& spec) { spec.compare.retention = Retention::kSketch; }},
        BadValue{"compare.retention is \"compact\"",
                 [](JobSpec& spec) { spec.compare.retention = Retention::kCompact; }}));

TEST(ExactSpec, RefusesWhatOnlyThePredecessorHas) {
  JobSpec spec;
  spec.icp.scale_mode = ScaleMode::kFromX;
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, "icp.scale is \"from-x\""));
  spec = JobSpec();
  spec.compare.sign = DistanceSign::kSigned;
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, "compare.sign is \"signed\""));
  spec = JobSpec();
  spec.position_bits = 0;
  EXPECT_THAT(spec.Validate(), StatusIs(kInvalid, "position_bits is 0, expected 8 to 30"));
}

}  // namespace
}  // namespace cohort
