#include "client/output/estimate_text.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace cohort {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Estimate SomeEstimate() {
  Estimate estimate;
  estimate.meshes = 200;
  estimate.pairs = 39800;
  estimate.stages = {{.name = "ingest", .tasks = 67, .core_seconds = 75, .is_measured = true},
                     {.name = "compare", .tasks = 325, .core_seconds = 7200, .is_measured = false}};
  estimate.slots = 16;
  estimate.wall_seconds = 460;
  estimate.retention = Retention::kCompact;
  estimate.distance_bytes = {{Retention::kVectors, 6'600'000'000},
                             {Retention::kCompact, 3'400'000'000},
                             {Retention::kSketch, 28'000'000},
                             {Retention::kMetrics, 0}};
  estimate.other_bytes = 100'000'000;
  estimate.free_bytes = 50'000'000'000;
  return estimate;
}

TEST(EstimateToText, TellsPairsTimeAndSpace) {
  EXPECT_EQ(EstimateToText(SomeEstimate()),
            "200 meshes, 39800 directed pairs\n"
            "stage              tasks         core time  rate\n"
            "ingest                67              1:15  measured\n"
            "compare              325    2.0 core-hours  assumed\n"
            "all                  392    2.0 core-hours  1 % of it by rates measured on this "
            "server, the rest assumed\n"
            "time           about 7:40 with the 16 slots of the workers there are\n"
            "written        vectors 6.6 GB, compact 3.4 GB (chosen), sketch 28.0 MB, metrics 0.0 "
            "kB; besides 100.0 MB\n"
            "in all         3.5 GB, the store has room for 50.0 GB\n");
}

TEST(EstimateToText, SaysWhatItDoesNotKnow) {
  Estimate estimate = SomeEstimate();
  estimate.slots = 0;
  estimate.free_bytes.reset();
  estimate.stages[0].is_measured = false;
  const std::string text = EstimateToText(estimate);
  EXPECT_THAT(text, HasSubstr("no workers now"));
  EXPECT_THAT(text, HasSubstr("has measured none yet"));
  EXPECT_THAT(text, Not(HasSubstr("room for")));
}

TEST(EstimateToText, SaysThatLittleIsMeasured) {
  Estimate estimate = SomeEstimate();
  estimate.stages[0].core_seconds = 1;
  EXPECT_THAT(EstimateToText(estimate), HasSubstr("less than 1 % of it by rates measured"));
}

TEST(EstimateWarnings, AreOfWhatDoesNotFitAndOfACostlyMethodEach) {
  Estimate estimate = SomeEstimate();
  EXPECT_EQ(EstimateWarnings(estimate), "");
  estimate.free_bytes = 3'000'000'000;
  EXPECT_THAT(EstimateWarnings(estimate),
              HasSubstr("warning: 3.5 GB do not fit into the store, which has room for 3.0 GB"));
  estimate = SomeEstimate();
  estimate.average_core_seconds = 7000;
  EXPECT_EQ(EstimateWarnings(estimate), "") << "hardly more";
  estimate.average_core_seconds = 291;
  EXPECT_EQ(EstimateWarnings(estimate),
            "warning: method each aligns every pair: 2.0 core-hours, 25 times the 4:51 of method "
            "average\n");
}

TEST(EstimateToJson, HasTheSameNumbers) {
  const nlohmann::json json = EstimateToJson(SomeEstimate());
  EXPECT_EQ(json["pairs"], 39800);
  EXPECT_EQ(json["core_seconds"], 7275);
  EXPECT_EQ(json["stages"][1]["tasks"], 325);
  EXPECT_EQ(json["distance_bytes"]["vectors"], 6'600'000'000);
  EXPECT_EQ(json["bytes_written"], 3'500'000'000);
  EXPECT_EQ(json["retention"], "compact");
  EXPECT_EQ(json["fits"], true);
}

}  // namespace
}  // namespace cohort
