#include "client/output/job_pace.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;

constexpr int64_t kNow = 1'700'000'000'000;

/// Runs since `age_seconds` before kNow; `share` of a cost of 200 is done, in 100 tasks.
Job JobAt(double share, double age_seconds) {
  Job job;
  job.state = JobState::kRunning;
  job.started_unix_ms = kNow - static_cast<int64_t>(age_seconds * 1000);
  job.progress.cost_total = 200;
  job.progress.cost_done = 200 * share;
  job.progress.tasks_total = 100;
  job.progress.tasks_done = static_cast<int64_t>(100 * share);
  return job;
}

TEST(JobPace, GoesByWhatWasSeen) {
  JobPace pace;
  pace.Note(JobAt(0, 0), 0, kNow);
  EXPECT_EQ(pace.RemainingSeconds(), std::nullopt);
  pace.Note(JobAt(0.25, 10), 10, kNow);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(30, 1e-9)));
  EXPECT_DOUBLE_EQ(pace.TasksPerSecond(), 2.5);
}

TEST(JobPace, OfAJobThatIsWatchedAgainGoesByItsAgeAtFirst) {
  JobPace pace;
  pace.Note(JobAt(0.5, 1000), 0.1, kNow);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(1000, 1e-9)));
  EXPECT_EQ(pace.TasksPerSecond(), 0) << "nothing was seen being done";
  pace.Note(JobAt(0.51, 1000), 10.1, kNow + 10'000);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(1010 * 0.49 / 0.51, 0.1)))
      << "a fiftieth of the rest says little";
  pace.Note(JobAt(0.6, 1000), 20.1, kNow + 20'000);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(80, 1e-6)))
      << "more workers than before";
}

TEST(JobPace, LeavesOutWhatWasKnownFromEarlierJobs) {
  JobPace pace;
  Job job = JobAt(0.8, 1);
  job.progress.tasks_reused = 80;
  pace.Note(job, 0.1, kNow);
  EXPECT_EQ(pace.RemainingSeconds(), std::nullopt) << "0.8 in a second would be a lie";
  job = JobAt(0.82, 11);
  job.progress.tasks_reused = 80;
  pace.Note(job, 10.1, kNow + 10'000);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(90, 1e-6)));
}

TEST(JobPace, BeginsAnewAfterAPauseAndAfterDamage) {
  JobPace pace;
  pace.Note(JobAt(0.1, 10), 0, kNow);
  Job paused = JobAt(0.3, 20);
  paused.state = JobState::kPaused;
  pace.Note(paused, 10, kNow);
  EXPECT_EQ(pace.RemainingSeconds(), std::nullopt);
  pace.Note(JobAt(0.3, 5000), 5000, kNow);
  EXPECT_EQ(pace.RemainingSeconds(), std::nullopt);
  pace.Note(JobAt(0.5, 5010), 5010, kNow);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(25, 1e-6)));
  pace.Note(JobAt(0.2, 5020), 5020, kNow);  // Put back.
  pace.Note(JobAt(0.4, 5030), 5030, kNow);
  EXPECT_THAT(pace.RemainingSeconds(), Optional(DoubleNear(30, 1e-6)));
}

TEST(JobPace, TellsNothingByAClockThatIsBehindTheServers) {
  JobPace pace;
  pace.Note(JobAt(0.5, -60), 0.1, kNow);
  EXPECT_EQ(pace.RemainingSeconds(), std::nullopt);
}

}  // namespace
}  // namespace cohort
