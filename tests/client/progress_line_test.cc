#include "client/output/progress_line.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

Job JobAt(double share, const std::string& stage) {
  Job job;
  job.progress = {.stage = stage,
                  .tasks_done = 50,
                  .tasks_total = 100,
                  .cost_done = share,
                  .cost_total = 1,
                  .stages = {},
                  .waiting_for = {}};
  return job;
}

TEST(FormatDuration, ReadsAsAClock) {
  EXPECT_EQ(FormatDuration(0), "0:00");
  EXPECT_EQ(FormatDuration(7.4), "0:07");
  EXPECT_EQ(FormatDuration(245), "4:05");
  EXPECT_EQ(FormatDuration(3723), "1:02:03");
}

TEST(FormatProgress, ShowsBarTasksRateAndEta) {
  EXPECT_EQ(FormatProgress(JobAt(0.25, "align 2"), 10, 8),
            "align 2      [##......]  25 %  50/100 tasks  5.0/s  ETA 0:30");
}

TEST(FormatProgress, PromisesNothingEarlyAndNothingAtTheEnd) {
  EXPECT_THAT(FormatProgress(JobAt(0.01, "ingest"), 10, 8),
              ::testing::Not(::testing::HasSubstr("ETA")));
  EXPECT_EQ(FormatProgress(JobAt(1, ""), 10, 8),
            "done         [########] 100 %  50/100 tasks  5.0/s");
}

}  // namespace
}  // namespace cohort
