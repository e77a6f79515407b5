#pragma once

#include <cstdint>
#include <functional>

namespace cohort {

/// Runs independent pieces of work; how computing code gets threads without starting any.
///
/// Results never depend on the executor: each piece writes only its own slot, and whoever called
/// combines the slots in index order.
class Executor {
 public:
  virtual ~Executor() = default;

  /// Calls `body(i)` once for each i in [0, count), in any order and possibly at once; returns when
  /// all are done. Must not be called from inside a body.
  virtual void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) = 0;
};

/// Runs every piece on the calling thread, in index order.
class SerialExecutor final : public Executor {
 public:
  void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) override {
    for (int64_t i = 0; i < count; ++i) {
      body(i);
    }
  }
};

}  // namespace cohort
