// Workers that wait inside Synchronize for a task: whatever becomes ready wakes one. The clock
// stands still here, so that one who misses its wake-up waits for ever.
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <latch>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/server/core/coordinator_fixture.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr std::chrono::seconds kPatience(60);     // For what must come.
constexpr std::chrono::milliseconds kSettle(50);  // For a thread to arrive at a lock.

class WaitingWorkerTest : public CoordinatorTest {
 protected:
  using Grants = std::future<std::vector<GrantedTask>>;

  using Answer = std::future<absl::StatusOr<WorkerOrders>>;

  /// A worker with a free slot that waits for a task.
  Grants Wait(const std::string& worker) {
    return std::async(std::launch::async, [this, worker] {
      return coordinator_->Synchronize(ReportOf(worker), [] { return false; })->grants;
    });
  }
  /// The same of one that may go meanwhile.
  Answer WaitUnless(const std::string& worker, std::function<bool()> is_cancelled) {
    return std::async(std::launch::async, [this, worker, is_cancelled = std::move(is_cancelled)] {
      return coordinator_->Synchronize(ReportOf(worker), is_cancelled);
    });
  }
  static WorkerReport ReportOf(const std::string& worker) {
    return {
        .worker = WorkerId{worker}, .build = "1", .held = {}, .free_slots = 1, .wait_seconds = 20};
  }

  /// Has the server look again at those who wait, for so long that they may have gone.
  void AskThoseWhoWait() {
    std::this_thread::sleep_for(kSettle);
    clock_.Advance(1);
    EXPECT_THAT(coordinator_->Tick(), IsOk());
  }

  /// What it was given; ends its wait, and those of all others, if that is nothing.
  std::vector<GrantedTask> Given(Grants& grants) {
    if (grants.wait_for(kPatience) != std::future_status::ready) {
      coordinator_->Stop();
    }
    return grants.get();
  }
};

TEST_F(WaitingWorkerTest, AStageThatEndsWakesThoseWhoWait) {
  AddScans(4, 1);
  Submit();
  const auto all = Take("w", 99);
  Grants waiting = Wait("waiting");
  for (const GrantedTask& granted : all) {
    EXPECT_THAT(Do("w", granted), IsOk());  // No way out before the one who waits has ended.
  }
  EXPECT_EQ(Given(waiting).size(), 1U);
}

// A report that another call has answered, with nothing, while it waited for the lock: what becomes
// ready before it has the lock itself has been announced already.
TEST_F(WaitingWorkerTest, AStageThatEndsBetweenAnAnswerAndItsWaitWakesItToo) {
  AddScans(4, 1);
  Submit();
  const auto all = Take("w", 99);
  for (size_t i = 1; i < all.size(); ++i) {
    ASSERT_THAT(Do("w", all[i]), IsOk());
  }
  std::latch holds(1);
  std::latch let_go(1);
  bool is_first = true;
  // Keeps the lock until the others stand before it, in this order; then it goes.
  auto holder = WaitUnless("holder", [&] {
    if (std::exchange(is_first, false)) {
      holds.count_down();
      let_go.wait();
    }
    return true;
  });
  AskThoseWhoWait();
  holds.wait();
  Grants answering = Wait("answering");
  std::this_thread::sleep_for(kSettle);
  auto done = std::async(std::launch::async, [&] { return Do("w", all[0]); });
  std::this_thread::sleep_for(kSettle + kSettle);
  Grants answered = Wait("answered");
  std::this_thread::sleep_for(kSettle);
  let_go.count_down();
  EXPECT_THAT(done.get(), IsOk());
  EXPECT_EQ(Given(answered).size() + Given(answering).size(), 2U);
  EXPECT_THAT(holder.get(), StatusIs(absl::StatusCode::kCancelled, "holder has gone"));
}

TEST_F(WaitingWorkerTest, OneWhoHasGoneIsGivenNothing) {
  AddScans(4, 1);
  Submit();
  const auto all = Take("w", 99);
  for (size_t i = 1; i < all.size(); ++i) {
    ASSERT_THAT(Do("w", all[i]), IsOk());
  }
  std::atomic<bool> has_gone = false;
  auto waiting = WaitUnless("waiting", [&] { return has_gone.load(); });
  AskThoseWhoWait();
  has_gone = true;
  ASSERT_THAT(Do("w", all[0]), IsOk());
  EXPECT_THAT(waiting.get(), StatusIs(absl::StatusCode::kCancelled, "waiting has gone"));
  for (const GrantedTask& granted : Take("other", 99)) {
    EXPECT_EQ(granted.lease.epoch, 1) << "task " << granted.task.number << " was given before";
  }
}

// A second result that is taken in before the one who waits has had the lock.
TEST_F(WaitingWorkerTest, OneWhoHasAnAnswerKeepsIt) {
  AddScans(4, 1);
  const Job job = Submit();
  auto all = Take("w", 99);
  const Job other_job = Submit();
  const GrantedTask of_other_job = Take("w", 99).at(0);
  ASSERT_EQ(of_other_job.lease.task.job, other_job.id);
  for (size_t i = 1; i < all.size(); ++i) {
    ASSERT_THAT(Do("w", all[i]), IsOk());
  }
  std::latch asked(1);
  std::latch let_go(1);
  bool is_first = true;
  auto waiting = WaitUnless("waiting", [&] {  // Under the lock: the next result stands before it.
    if (std::exchange(is_first, false)) {
      asked.count_down();
      let_go.wait();
    }
    return false;
  });
  std::this_thread::sleep_for(kSettle);
  clock_.Advance(1);
  auto first = std::async(std::launch::async, [&] { return Do("w", all[0]); });
  asked.wait();
  auto second = std::async(std::launch::async, [&] { return Do("w", of_other_job); });
  std::this_thread::sleep_for(kSettle);
  let_go.count_down();
  EXPECT_THAT(first.get(), IsOk());
  EXPECT_THAT(second.get(), IsOk());
  const auto orders = waiting.get();
  ASSERT_THAT(orders, IsOk());
  EXPECT_EQ(orders->grants.size(), 1U);
  size_t of_job = 0;
  auto left = Take("other", 99);
  left.insert(left.end(), orders->grants.begin(), orders->grants.end());
  for (const GrantedTask& granted : left) {
    of_job += granted.lease.task.job == job.id ? 1 : 0;
  }
  EXPECT_EQ(of_job, 4U) << "one task for each mesh: none is lost between";
}

// It costs as much as the answer, and the caller has just called.
TEST_F(WaitingWorkerTest, OneWhoIsAnsweredAtOnceIsNotAskedWhetherItIsThere) {
  AddScans(4, 1);
  Submit();
  const WorkerReport report{
      .worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = 1, .wait_seconds = 20};
  const auto orders = coordinator_->Synchronize(report, [] {
    ADD_FAILURE() << "asked";
    return false;
  });
  ASSERT_THAT(orders, IsOk());
  EXPECT_EQ(orders->grants.size(), 1U);
}

}  // namespace
}  // namespace cohort
