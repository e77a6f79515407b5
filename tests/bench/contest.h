#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

namespace cohort {

/// CPU time of the calling thread, seconds: other programs on the machine do not count.
[[nodiscard]] double ThreadSeconds();

/// Thread CPU seconds that `work` takes.
template <typename Work>
[[nodiscard]] double SecondsOf(Work&& work) {
  const double start = ThreadSeconds();
  std::forward<Work>(work)();
  return ThreadSeconds() - start;
}

/// Candidates that do the same work, measured in turns: whatever disturbs the machine for a while
/// disturbs all of them. Not thread-safe.
class Contest {
 public:
  /// Adds a candidate; the order of calls is the order within a round.
  /// @param units  what one call of `work` does (queries, pairs, meshes), > 0.
  /// @param work  does it once and returns the seconds that count.
  /// @param most_rounds  slow ones need not run in every round.
  void Add(std::string name,
           double units,
           std::function<double()> work,
           int most_rounds = std::numeric_limits<int>::max());

  /// Each candidate once untimed, then once in every iteration of `state`; leaves nanoseconds a
  /// unit in its counters.
  void Run(benchmark::State& state);

  [[nodiscard]] bool Has(std::string_view name) const { return Find(name) != nullptr; }
  /// Median over the rounds of the nanoseconds a unit. `name` must have been added and run.
  [[nodiscard]] double Nanoseconds(std::string_view name) const;
  /// Median over the rounds that both ran in of time(numerator) / time(denominator), each a unit.
  [[nodiscard]] double Ratio(std::string_view numerator, std::string_view denominator) const;

 private:
  struct Candidate {
    std::string name;
    double units;
    std::function<double()> work;
    int most_rounds;
    std::vector<double> seconds;  // of one unit, per round
  };
  [[nodiscard]] const Candidate* Find(std::string_view name) const;
  double RunRound();

  std::vector<Candidate> candidates_;
};

/// The middle value; the mean of the two middle ones of an even number. `values` is not empty.
[[nodiscard]] double Median(std::vector<double> values);

}  // namespace cohort
