#include "tests/bench/contest.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <ctime>

namespace cohort {
namespace {

constexpr double kNanoseconds = 1e9;

}  // namespace

double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / kNanoseconds;
}

double Median(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

void Contest::Add(std::string name, double units, std::function<double()> work, int most_rounds) {
  assert(units > 0 && most_rounds > 0);
  candidates_.push_back({std::move(name), units, std::move(work), most_rounds, {}});
}

void Contest::Run(benchmark::State& state) {
  for (const Candidate& candidate : candidates_) {
    if (candidate.most_rounds > 1) {
      (void)candidate.work();
    }
  }
  for ([[maybe_unused]] auto _ : state) {
    state.SetIterationTime(RunRound());
  }
  for (const Candidate& candidate : candidates_) {
    state.counters[candidate.name + " ns"] = Nanoseconds(candidate.name);
  }
}

double Contest::RunRound() {
  double all = 0;
  for (Candidate& candidate : candidates_) {
    if (candidate.seconds.size() < static_cast<size_t>(candidate.most_rounds)) {
      const double seconds = candidate.work();
      candidate.seconds.push_back(seconds / candidate.units);
      all += seconds;
    }
  }
  return all;
}

const Contest::Candidate* Contest::Find(std::string_view name) const {
  const auto found = std::find_if(candidates_.begin(), candidates_.end(),
                                  [name](const Candidate& c) { return c.name == name; });
  return found == candidates_.end() ? nullptr : &*found;
}

double Contest::Nanoseconds(std::string_view name) const {
  const Candidate* candidate = Find(name);
  assert(candidate != nullptr);
  return Median(candidate->seconds) * kNanoseconds;
}

double Contest::Ratio(std::string_view numerator, std::string_view denominator) const {
  const Candidate* above = Find(numerator);
  const Candidate* below = Find(denominator);
  assert(above != nullptr && below != nullptr);
  std::vector<double> ratios;
  for (size_t round = 0; round < std::min(above->seconds.size(), below->seconds.size()); ++round) {
    ratios.push_back(above->seconds[round] / below->seconds[round]);
  }
  return Median(std::move(ratios));
}

}  // namespace cohort
