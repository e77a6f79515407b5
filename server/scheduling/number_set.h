#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

namespace cohort {

/// A set of numbers kept as runs: a million tasks that nothing has happened to yet are one entry.
/// Each call costs O(log runs).
class NumberSet {
 public:
  /// Adds first, ..., first + count - 1; those that are there stay.
  void InsertRange(int64_t first, int64_t count) {
    if (count <= 0) {
      return;
    }
    int64_t begin = first;
    int64_t end = first + count;
    auto run = runs_.upper_bound(begin);
    if (run != runs_.begin() && std::prev(run)->second >= begin) {
      --run;
    }
    while (run != runs_.end() && run->first <= end) {
      begin = std::min(begin, run->first);
      end = std::max(end, run->second);
      size_ -= run->second - run->first;
      run = runs_.erase(run);
    }
    runs_.emplace(begin, end);
    size_ += end - begin;
  }
  void Insert(int64_t number) { InsertRange(number, 1); }

  void Erase(int64_t number) {
    const auto run = RunOf(number);
    if (run == runs_.end()) {
      return;
    }
    const auto [begin, end] = *run;
    runs_.erase(run);
    if (begin < number) {
      runs_.emplace(begin, number);
    }
    if (number + 1 < end) {
      runs_.emplace(number + 1, end);
    }
    --size_;
  }

  [[nodiscard]] bool Contains(int64_t number) const { return RunOf(number) != runs_.end(); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] int64_t Size() const { return size_; }
  /// The least. The set must not be empty.
  [[nodiscard]] int64_t First() const {
    assert(!runs_.empty());
    return runs_.begin()->first;
  }

  /// Calls `visit` with the least `count` numbers, ascending.
  template <typename Visit>
  void ForEachOfFirst(int64_t count, Visit visit) const {
    for (const auto& [begin, end] : runs_) {
      for (int64_t number = begin; number < end; ++number) {
        if (count-- <= 0) {
          return;
        }
        visit(number);
      }
    }
  }

 private:
  using Runs = std::map<int64_t, int64_t>;  ///< From begin to end, neither touching another.

  [[nodiscard]] Runs::const_iterator RunOf(int64_t number) const {
    const auto after = runs_.upper_bound(number);
    if (after == runs_.begin() || std::prev(after)->second <= number) {
      return runs_.end();
    }
    return std::prev(after);
  }

  Runs runs_;
  int64_t size_ = 0;
};

}  // namespace cohort
