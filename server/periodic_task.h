#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <thread>

namespace cohort {

/// Does something again and again on a thread of its own, until it is destroyed.
class PeriodicTask {
 public:
  /// @param work  is to end soon once its argument says so.
  PeriodicTask(std::chrono::steady_clock::duration first_after,
               std::chrono::steady_clock::duration period,
               std::function<void(const std::stop_token&)> work);

 private:
  std::jthread thread_;
};

}  // namespace cohort
