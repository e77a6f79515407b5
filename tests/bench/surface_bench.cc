#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/nearest/surface_search.h"
#include "tests/bench/bench.h"
#include "tests/bench/error_meter.h"
#include "tests/bench/search_duel.h"

namespace cohort {
namespace {

constexpr std::string_view kOurs = "Cohort";

/// A rival's scenes of the targets and its last answers.
class RivalSurfaces {
 public:
  RivalSurfaces(const SurfaceRivalKind& kind, const std::vector<SearchPair>& pairs)
      : pairs_(pairs), answers_(pairs.size()) {
    for (size_t i = 0; i < pairs.size(); ++i) {
      const BenchMesh* target = pairs[i].target;
      answers_[i].resize(static_cast<size_t>(pairs[i].query->mesh.VertexCount()));
      if (rivals_.count(target) == 0) {
        build_seconds_ += SecondsOf(
            [&] { rivals_.emplace(target, kind.make(target->Points(), target->Triangles())); });
      }
    }
  }

  void FindAll() {
    for (size_t i = 0; i < pairs_.size(); ++i) {
      rivals_.at(pairs_[i].target)->Find(pairs_[i].query->Points(), answers_[i].data());
    }
  }
  /// Squared distances of pair i, in the order of its vertices.
  [[nodiscard]] const std::vector<double>& Answer(size_t i) const { return answers_[i]; }
  /// Of one target.
  [[nodiscard]] double BuildSeconds() const {
    return build_seconds_ / static_cast<double>(rivals_.size());
  }

 private:
  const std::vector<SearchPair>& pairs_;
  std::map<const BenchMesh*, std::unique_ptr<SurfaceRival>> rivals_;
  std::vector<std::vector<double>> answers_;
  double build_seconds_ = 0;
};

/// Ours: nearest vertices not needed before, index and distances out.
struct OwnSurfaces {
  std::map<const BenchMesh*, std::unique_ptr<PackedSurface>> targets;
  std::vector<NearestOnSurface> answers;
  SurfaceSearch search;
  double build_seconds = 0;

  explicit OwnSurfaces(const std::vector<SearchPair>& pairs) : answers(pairs.size()) {
    for (const SearchPair& pair : pairs) {
      if (targets.count(pair.target) == 0) {
        build_seconds += SecondsOf([&] {
          targets.emplace(pair.target, std::make_unique<PackedSurface>(pair.target->vertices,
                                                                       pair.target->mesh.faces));
        });
      }
    }
  }
};

ErrorMeter MeasureError(const OwnSurfaces& ours,
                        const RivalSurfaces& truth,
                        const std::vector<SearchPair>& pairs) {
  ErrorMeter meter;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PackedMesh& query = pairs[i].query->packed;
    for (size_t slot = 0; slot < static_cast<size_t>(query.VertexCount()); ++slot) {
      const auto vertex = static_cast<size_t>(query.VertexOfSlot()[slot]);
      meter.Add(ours.answers[i].squared_distances[slot], truth.Answer(i)[vertex]);
    }
  }
  return meter;
}

using Rivals = std::map<std::string_view, std::unique_ptr<RivalSurfaces>>;

void AddDuel(Bench& bench,
             const Contest& contest,
             const std::string& label,
             const std::string& rival,
             double goal) {
  Figure figure{absl::StrCat("vertex to surface against ", rival, ", ", label),
                AtLeast(goal),
                {},
                " x",
                absl::StrCat(rival, " was not found when this was built")};
  if (contest.Has(rival)) {
    figure.value = contest.Ratio(rival, kOurs);
    figure.note = absl::StrCat(Digits(contest.Nanoseconds(kOurs)), " ns a query against ",
                               Digits(contest.Nanoseconds(rival)));
  }
  bench.figures.Add(figure);
}

void AddTimes(Bench& bench, const Contest& contest, const std::string& label) {
  const auto add = [&](std::string_view name) {
    bench.figures.Add(RivalTime{std::string(name), absl::StrCat("surface, ", label),
                                contest.Nanoseconds(name), contest.Ratio(name, kOurs)});
  };
  add(kOurs);
  for (const SurfaceRivalKind& kind : SurfaceRivals()) {
    add(kind.name);
  }
}

Rivals AddRivals(Contest& contest, const std::vector<SearchPair>& pairs) {
  constexpr int kAllRounds = 1000;
  Rivals rivals;
  for (const SurfaceRivalKind& kind : SurfaceRivals()) {
    rivals[kind.name] = std::make_unique<RivalSurfaces>(kind, pairs);
    const bool is_judged = kind.name == kEmbree || kind.name == kCgal;
    contest.Add(
        std::string(kind.name), QueryCount(pairs),
        [surfaces = rivals[kind.name].get()] { return SecondsOf([&] { surfaces->FindAll(); }); },
        is_judged ? kAllRounds : 1);
  }
  return rivals;
}

absl::Status MeasureSurface(Bench& bench, benchmark::State& state, int vertices) {
  const int meshes = bench.options.IsQuick() ? 2 : 3;
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, meshes));
  const std::vector<SearchPair> pairs = AllPairs(faces);
  const std::string label = absl::StrCat(vertices / 1000, "k");
  OwnSurfaces ours(pairs);
  Contest contest;
  contest.Add(std::string(kOurs), QueryCount(pairs), [&] {
    return SecondsOf([&] {
      for (size_t i = 0; i < pairs.size(); ++i) {
        ours.search.Find(pairs[i].query->packed, *ours.targets.at(pairs[i].target),
                         ours.answers[i]);
      }
    });
  });
  const Rivals rivals = AddRivals(contest, pairs);
  contest.Run(state);
  AddDuel(bench, contest, label, std::string(kEmbree), 7);
  AddDuel(bench, contest, label, std::string(kCgal), 14);
  AddTimes(bench, contest, label);
  if (rivals.count(kCgal) != 0) {
    bench.figures.Add(MeasureError(ours, *rivals.at(kCgal), pairs)
                          .ToFigure(absl::StrCat("error of the distances to the surface, ", label),
                                    "CGAL in double"));
  }
  return absl::OkStatus();
}

}  // namespace

void RegisterSurface(Bench& bench) {
  const int rounds = bench.options.IsQuick() ? 3 : 7;
  for (const int vertices : {10'000, 20'000, 60'000}) {
    Register(bench, absl::StrCat("surface/", vertices / 1000, "k"), rounds,
             [vertices](Bench& b, benchmark::State& state) {
               return MeasureSurface(b, state, vertices);
             });
  }
}

}  // namespace cohort
