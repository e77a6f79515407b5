// Workers that wait inside Synchronize for a task: whatever becomes ready wakes one. The clock
// stands still here, so that one who misses its wake-up waits for ever.
#include <chrono>
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

constexpr std::chrono::seconds kPatience(60);     // For what must come.
constexpr std::chrono::milliseconds kSettle(50);  // For a thread to arrive at a lock.

class WaitingWorkerTest : public CoordinatorTest {
 protected:
  using Grants = std::future<std::vector<GrantedTask>>;

  /// A worker with a free slot that waits for a task.
  Grants Wait(const std::string& worker) {
    return std::async(std::launch::async, [this, worker] {
      const WorkerReport report{.worker = WorkerId{worker},
                                .build = "1",
                                .held = {},
                                .free_slots = 1,
                                .wait_seconds = 20};
      return coordinator_->Synchronize(report, [] { return false; })->grants;
    });
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
  std::thread holder([&] {  // Keeps the lock until the others stand before it, in this order.
    const WorkerReport report{.worker = WorkerId{"holder"}, .build = "1", .held = {}};
    (void)coordinator_->Synchronize(report, [&] {
      if (std::exchange(is_first, false)) {
        holds.count_down();
        let_go.wait();
      }
      return false;
    });
  });
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
  holder.join();
}

}  // namespace
}  // namespace cohort
