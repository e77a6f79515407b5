#include "worker/tasks/compute_slots.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

TEST(ComputeSlots, NeverLetsMoreComputeThanThereAreSlots) {
  constexpr int kSlots = 2;
  ComputeSlots slots(kSlots);
  std::atomic<int> computing = 0;
  std::atomic<int> most = 0;
  std::atomic<int> done = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < 50; ++round) {
        auto permit = slots.Acquire({});
        ASSERT_TRUE(permit.ok());
        const int now = ++computing;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::yield();
        --computing;
        permit->Release();
        ++done;
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(done, 300);
  EXPECT_LE(most, kSlots);
}

TEST(ComputeSlots, GiveASlotBackOnceHoweverOftenItIsReleased) {
  ComputeSlots slots(1);
  {
    auto permit = slots.Acquire({});
    ASSERT_TRUE(permit.ok());
    permit->Release();
    permit->Release();
  }
  auto first = slots.Acquire({});
  ASSERT_TRUE(first.ok());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THAT(slots.Acquire(stop.get_token()).status(),
              testing::StatusIs(absl::StatusCode::kCancelled, "stopped"));
}

TEST(ComputeSlots, AWaitEndsWhenItIsStopped) {
  ComputeSlots slots(1);
  auto held = slots.Acquire({});
  ASSERT_TRUE(held.ok());
  std::stop_source stop;
  absl::Status status;
  std::thread waiting([&] { status = slots.Acquire(stop.get_token()).status(); });
  stop.request_stop();
  waiting.join();
  EXPECT_THAT(status, testing::StatusIs(absl::StatusCode::kCancelled, "stopped"));
  held->Release();
  EXPECT_TRUE(slots.Acquire({}).ok());  // Nobody who has gone stands in the way.
}

}  // namespace
}  // namespace cohort
