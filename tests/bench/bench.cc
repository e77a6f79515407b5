#include "tests/bench/bench.h"

#include <utility>

namespace cohort {

void Register(Bench& bench, const std::string& name, int rounds, Measure measure) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [&bench, measure = std::move(measure)](benchmark::State& state) {
                                 const absl::Status status = measure(bench, state);
                                 if (!status.ok()) {
                                   state.SkipWithError(std::string(status.message()).c_str());
                                 } else if (state.iterations() == 0) {
                                   // Could not be measured here; Google Benchmark wants its rounds.
                                   for ([[maybe_unused]] auto _ : state) {
                                     state.SetIterationTime(1);
                                   }
                                 }
                               })
      ->Iterations(rounds)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace cohort
