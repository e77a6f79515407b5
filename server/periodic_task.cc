#include "server/periodic_task.h"

#include <utility>

#include "common/base/mutex.h"

namespace cohort {
namespace {

/// False: stopped before.
bool WaitUntil(const std::stop_token& stop, std::chrono::steady_clock::time_point end) {
  Mutex mutex;
  CondVar stopped;
  const std::stop_callback wake(stop, [&] {
    const MutexLock lock(mutex);
    stopped.NotifyAll();
  });
  const MutexLock lock(mutex);
  while (!stop.stop_requested() && std::chrono::steady_clock::now() < end) {
    stopped.WaitUntil(mutex, end);
  }
  return !stop.stop_requested();
}

}  // namespace

PeriodicTask::PeriodicTask(std::chrono::steady_clock::duration first_after,
                           std::chrono::steady_clock::duration period,
                           std::function<void(const std::stop_token&)> work)
    : thread_([first_after, period, work = std::move(work)](const std::stop_token& stop) {
        auto next = std::chrono::steady_clock::now() + first_after;
        while (WaitUntil(stop, next)) {
          work(stop);
          next = std::chrono::steady_clock::now() + period;
        }
      }) {}

}  // namespace cohort
