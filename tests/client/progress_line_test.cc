#include "client/output/progress_line.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

Job JobAt(double share, const std::string& stage) {
  Job job;
  job.state = JobState::kRunning;
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

/// The pace of a job that was seen at no share and then, after ten seconds, at `job`.
JobPace PaceTo(const Job& job) {
  JobPace pace;
  Job begin = job;
  begin.progress.cost_done = 0;
  begin.progress.tasks_done = 0;
  pace.Note(begin, 0, 0);
  pace.Note(job, 10, 0);
  return pace;
}

TEST(FormatProgress, ShowsBarTasksRateAndEta) {
  const Job job = JobAt(0.25, "align 2");
  EXPECT_EQ(FormatProgress(job, PaceTo(job), 8),
            "align 2      [##......]  25 %  50/100 tasks  5.0/s  ETA 0:30");
}

TEST(FormatProgress, PromisesNothingEarlyAndNothingAtTheEnd) {
  const Job early = JobAt(0.01, "ingest");
  EXPECT_THAT(FormatProgress(early, PaceTo(early), 8), ::testing::Not(::testing::HasSubstr("ETA")));
  const Job done = JobAt(1, "");
  EXPECT_EQ(FormatProgress(done, PaceTo(done), 8),
            "done         [########] 100 %  50/100 tasks  5.0/s");
}

TEST(FormatProgress, SaysThatAJobIsHeldAndPromisesNothing) {
  Job job = JobAt(0.5, "compare");
  job.state = JobState::kPaused;
  EXPECT_EQ(FormatProgress(job, JobPace(), 8),
            "compare      [####....]  50 %  50/100 tasks  paused");
}

}  // namespace
}  // namespace cohort
