#include "common/base/thread_pool.h"

#include <cassert>
#include <utility>

namespace cohort {

ThreadPool::ThreadPool(int threads) {
  assert(threads >= 1);
  for (int i = 1; i < threads; ++i) {
    threads_.emplace_back([this] { RunHelper(); });
  }
}

ThreadPool::~ThreadPool() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
  }
  work_.NotifyAll();
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void ThreadPool::ParallelFor(int64_t count, const std::function<void(int64_t)>& body) {
  MutexLock loop(loop_mutex_);
  {
    MutexLock lock(mutex_);
    body_ = &body;
    next_ = 0;
    count_ = count;
  }
  work_.NotifyAll();
  Drain();
  std::exception_ptr thrown;
  {
    MutexLock lock(mutex_);
    while (running_ > 0) {
      done_.Wait(mutex_);
    }
    body_ = nullptr;
    thrown = std::exchange(thrown_, nullptr);
  }
  if (thrown != nullptr) {
    std::rethrow_exception(thrown);
  }
}

void ThreadPool::RunHelper() {
  while (true) {
    {
      MutexLock lock(mutex_);
      while (!stopping_ && (body_ == nullptr || next_ >= count_)) {
        work_.Wait(mutex_);
      }
      if (stopping_) {
        return;
      }
    }
    Drain();
  }
}

void ThreadPool::Drain() {
  while (true) {
    const std::function<void(int64_t)>* body = nullptr;
    int64_t index = 0;
    {
      MutexLock lock(mutex_);
      if (body_ == nullptr || next_ >= count_) {
        return;
      }
      body = body_;
      index = next_++;
      ++running_;
    }
    std::exception_ptr thrown;
    try {
      (*body)(index);
    } catch (...) {
      thrown = std::current_exception();
    }
    {
      MutexLock lock(mutex_);
      --running_;
      if (thrown != nullptr) {
        thrown_ = thrown;
        next_ = count_;
      }
      if (running_ == 0 && next_ >= count_) {
        done_.NotifyAll();
      }
    }
  }
}

}  // namespace cohort
