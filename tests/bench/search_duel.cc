#include "tests/bench/search_duel.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include <absl/strings/str_cat.h>

#include "common/geometry/nearest/instruction_set.h"
#include "common/geometry/nearest/packet_search.h"

namespace cohort {
namespace {

struct Path {
  InstructionSet set;
  std::string title;
  double SearchGoals::*goal;
};
const std::array<Path, 3>& Paths() {
  static const std::array<Path, 3> paths = {
      {{InstructionSet::kAvx512, "AVX-512", &SearchGoals::avx512},
       {InstructionSet::kAvx2, "AVX2", &SearchGoals::avx2},
       {InstructionSet::kPortable, "portable", &SearchGoals::portable}}};
  return paths;
}

bool IsAvailable(InstructionSet set) {
  const std::vector<InstructionSet> sets = AvailableInstructionSets();
  return std::find(sets.begin(), sets.end(), set) != sets.end();
}

void AddOurs(Contest& contest, const Path& path, const std::vector<SearchPair>& pairs) {
  auto search = std::make_shared<PacketSearch>(path.set);
  auto nearest = std::make_shared<NearestSlots>();
  contest.Add(path.title, QueryCount(pairs), [search, nearest, &pairs] {
    return SecondsOf([&] {
      for (const SearchPair& pair : pairs) {
        search->Find(pair.query->packed, pair.target->packed, *nearest);
      }
    });
  });
}

void AddFigure(Bench& bench, const SearchDuel& duel, const Contest& contest, const Path& path) {
  const double goal = duel.goals.*path.goal;
  Figure figure;
  figure.name = absl::StrCat(duel.name, ", ", path.title);
  figure.goal = goal > 0 ? AtLeast(goal) : Goal{};
  figure.unit = " x";
  figure.note = "this machine or build has no such path";
  if (contest.Has(path.title)) {
    figure.value = contest.Ratio(kBase, path.title);
    figure.note = absl::StrCat(Digits(contest.Nanoseconds(path.title)), " ns a query against ",
                               Digits(contest.Nanoseconds(kBase)));
  }
  bench.figures.Add(figure);
}

/// Our fastest path and all rivals.
void AddTimes(Bench& bench,
              const SearchDuel& duel,
              const Contest& contest,
              const std::vector<NearestRivalKind>& rivals) {
  const auto ours = std::find_if(Paths().begin(), Paths().end(),
                                 [](const Path& path) { return IsAvailable(path.set); });
  const auto add = [&](std::string_view name, std::string_view candidate) {
    bench.figures.Add(RivalTime{std::string(name), duel.rival_column,
                                contest.Nanoseconds(candidate),
                                contest.Ratio(candidate, ours->title)});
  };
  add("Cohort", ours->title);
  for (const NearestRivalKind& rival : rivals) {
    add(rival.name, rival.name);
  }
}

}  // namespace

std::vector<SearchPair> AllPairs(std::span<const BenchMesh> meshes) {
  std::vector<SearchPair> pairs;
  for (const BenchMesh& query : meshes) {
    for (const BenchMesh& target : meshes) {
      if (&query != &target) {
        pairs.push_back({&query, &target});
      }
    }
  }
  return pairs;
}

double QueryCount(const std::vector<SearchPair>& pairs) {
  double count = 0;
  for (const SearchPair& pair : pairs) {
    count += static_cast<double>(pair.query->mesh.VertexCount());
  }
  return count;
}

void AddRival(Contest& contest,
              const NearestRivalKind& kind,
              const std::vector<SearchPair>& pairs,
              int most_rounds) {
  auto rivals = std::make_shared<std::map<const BenchMesh*, std::unique_ptr<NearestRival>>>();
  int64_t most = 0;
  for (const SearchPair& pair : pairs) {
    most = std::max(most, pair.query->mesh.VertexCount());
    if (rivals->count(pair.target) == 0) {
      rivals->emplace(pair.target, kind.make(pair.target->Points()));
    }
  }
  auto nearest = std::make_shared<std::vector<int32_t>>(static_cast<size_t>(most));
  auto squares = std::make_shared<std::vector<double>>(static_cast<size_t>(most));
  const auto work = [rivals, nearest, squares, &pairs] {
    return SecondsOf([&] {
      for (const SearchPair& pair : pairs) {
        rivals->at(pair.target)->Find(pair.query->Points(), nearest->data(), squares->data());
      }
    });
  };
  contest.Add(std::string(kind.name), QueryCount(pairs), work, most_rounds);
}

void RunSearchDuel(Bench& bench, benchmark::State& state, const SearchDuel& duel) {
  constexpr int kAllRounds = 1000;
  const int rival_rounds = bench.options.IsQuick() ? 1 : 3;
  Contest contest;
  const std::vector<NearestRivalKind> rivals = NearestRivals();
  AddRival(contest, rivals.front(), duel.pairs, kAllRounds);
  for (const Path& path : Paths()) {
    if (IsAvailable(path.set)) {
      AddOurs(contest, path, duel.pairs);
    }
  }
  for (size_t i = 1; i < rivals.size() && duel.with_rivals; ++i) {
    AddRival(contest, rivals[i], duel.pairs, rival_rounds);
  }
  contest.Run(state);
  for (const Path& path : Paths()) {
    AddFigure(bench, duel, contest, path);
  }
  if (duel.with_rivals) {
    AddTimes(bench, duel, contest, rivals);
  }
}

}  // namespace cohort
