#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/bench/bench.h"

namespace cohort {

struct SearchPair {
  const BenchMesh* query;
  const BenchMesh* target;
};
/// Every mesh against every other one.
[[nodiscard]] std::vector<SearchPair> AllPairs(std::span<const BenchMesh> meshes);
[[nodiscard]] double QueryCount(const std::vector<SearchPair>& pairs);

/// Least ratios of BASE's time to ours; 0: no goal.
struct SearchGoals {
  double avx512;
  double avx2;
  double portable;
};

/// Nearest-vertex search of all pairs by BASE and by each of our instruction sets.
struct SearchDuel {
  std::string name;
  std::vector<SearchPair> pairs;
  SearchGoals goals{};
  bool with_rivals = false;
  std::string rival_column = {};  ///< Where the rivals' times go.
};

/// Runs it and adds a figure for each instruction set that has a goal or is here.
void RunSearchDuel(Bench& bench, benchmark::State& state, const SearchDuel& duel);

/// Adds a rival's search of all pairs; its indexes are built now.
void AddRival(Contest& contest,
              const NearestRivalKind& kind,
              const std::vector<SearchPair>& pairs,
              int most_rounds);

}  // namespace cohort
