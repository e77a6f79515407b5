#include "common/base/thread_pool.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(ThreadPool, CallsTheBodyOnceForEachIndex) {
  ThreadPool pool(4);
  std::vector<std::atomic<int>> calls(10'000);

  pool.ParallelFor(10'000, [&](int64_t i) { ++calls[static_cast<size_t>(i)]; });

  for (size_t i = 0; i < calls.size(); ++i) {
    ASSERT_EQ(calls[i], 1) << "index " << i;
  }
}

TEST(ThreadPool, OfOneThreadRunsInOrderOnTheCaller) {
  ThreadPool pool(1);
  std::vector<int64_t> indices;

  pool.ParallelFor(5, [&](int64_t i) { indices.push_back(i); });

  EXPECT_EQ(indices, (std::vector<int64_t>{0, 1, 2, 3, 4}));
}

TEST(ThreadPool, ReturnsFromAnEmptyLoop) {
  ThreadPool pool(3);

  pool.ParallelFor(0, [](int64_t) { FAIL(); });
}

// Each body waits until three run at once: done by fewer threads it would never end.
TEST(ThreadPool, RunsAsManyBodiesAtOnceAsItHasThreads) {
  ThreadPool pool(3);
  std::mutex mutex;
  std::condition_variable all_here;
  int here = 0;

  pool.ParallelFor(3, [&](int64_t) {
    std::unique_lock<std::mutex> lock(mutex);
    ++here;
    all_here.notify_all();
    all_here.wait(lock, [&] { return here == 3; });
  });

  EXPECT_EQ(here, 3);
}

TEST(ThreadPool, RunsManyShortLoopsOneAfterAnother) {
  ThreadPool pool(4);
  std::atomic<int64_t> sum{0};

  for (int loop = 0; loop < 2'000; ++loop) {
    pool.ParallelFor(3, [&](int64_t i) { sum += i; });
  }

  EXPECT_EQ(sum, 2'000 * 3);
}

TEST(ThreadPool, LetsCallersTakeTurns) {
  ThreadPool pool(3);
  std::atomic<int64_t> sum{0};
  std::vector<std::thread> callers;
  callers.reserve(4);
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&] {
      for (int loop = 0; loop < 100; ++loop) {
        pool.ParallelFor(10, [&](int64_t i) { sum += i; });
      }
    });
  }
  for (std::thread& caller : callers) {
    caller.join();
  }

  EXPECT_EQ(sum, 4 * 100 * 45);
}

TEST(ThreadPool, ThrowsOnWhatABodyThrowsAndStaysUsable) {
  ThreadPool pool(4);
  const auto throw_at_7 = [](int64_t i) {
    if (i == 7) {
      throw std::runtime_error("seven");
    }
  };

  EXPECT_THROW(pool.ParallelFor(1'000, throw_at_7), std::runtime_error);

  std::atomic<int> calls{0};
  pool.ParallelFor(100, [&](int64_t) { ++calls; });
  EXPECT_EQ(calls, 100);
}

}  // namespace
}  // namespace cohort
