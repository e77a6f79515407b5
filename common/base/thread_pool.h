#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

#include "common/base/executor.h"
#include "common/base/mutex.h"

namespace cohort {

/// Executor over a fixed number of threads, of which the caller of ParallelFor is one.
/// Thread-safe: one ParallelFor runs at a time, a second caller waits for it.
class ThreadPool final : public Executor {
 public:
  /// @param threads  at least 1; 1 starts none and runs everything on the caller.
  explicit ThreadPool(int threads);
  ~ThreadPool() override;
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// What a body throws (a library's exception: ours throw none) ends the loop early and is thrown
  /// on to the caller, as by SerialExecutor, once no body runs any more.
  void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) override;

 private:
  void RunHelper();
  /// Takes indices of the current loop until none is left.
  void Drain();

  Mutex loop_mutex_;  ///< Held by ParallelFor from start to end.
  Mutex mutex_;
  CondVar work_;
  CondVar done_;
  const std::function<void(int64_t)>* body_ ABSL_GUARDED_BY(mutex_) = nullptr;
  int64_t next_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t running_ ABSL_GUARDED_BY(mutex_) = 0;
  std::exception_ptr thrown_ ABSL_GUARDED_BY(mutex_);  ///< By a body of the current loop.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace cohort
