#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/nearest/packet_search.h"
#include "tests/bench/bench.h"
#include "tests/bench/error_meter.h"
#include "tests/bench/search_duel.h"

namespace cohort {
namespace {

constexpr int kMeshes = 4;  // 12 ordered pairs

struct Size {
  int vertices;
  SearchGoals goals;
};
constexpr std::array<Size, 3> kSizes = {
    {{10'000, {14, 9.5, 1}}, {20'000, {15, 10, 1}}, {60'000, {17, 11.5, 1}}}};

/// The fastest path's distances against nanoflann's in double.
ErrorMeter MeasureError(const std::vector<SearchPair>& pairs) {
  ErrorMeter meter;
  PacketSearch search;
  NearestSlots found;
  for (const SearchPair& pair : pairs) {
    const auto rival = NearestRivals().front().make(pair.target->Points());
    std::vector<int32_t> nearest(static_cast<size_t>(pair.query->mesh.VertexCount()));
    std::vector<double> squares(nearest.size());
    rival->Find(pair.query->Points(), nearest.data(), squares.data());
    search.Find(pair.query->packed, pair.target->packed, found);
    for (size_t slot = 0; slot < nearest.size(); ++slot) {
      const auto vertex = static_cast<size_t>(pair.query->packed.VertexOfSlot()[slot]);
      meter.Add(found.squared_distances[slot], squares[vertex]);
    }
  }
  return meter;
}

/// "2.03 mm": mean RMS of the pairs.
std::string MeanRms(const std::vector<SearchPair>& pairs) {
  double sum = 0;
  for (const SearchPair& pair : pairs) {
    sum += NearestRms(*pair.query, *pair.target);
  }
  return Digits(sum / static_cast<double>(pairs.size())) + " mm";
}

absl::Status MeasureFaces(Bench& bench, benchmark::State& state, const Size& size) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(size.vertices, kMeshes));
  const std::string label = absl::StrCat(size.vertices / 1000, "k");
  SearchDuel duel{.name = absl::StrCat("all nearest neighbours, ", label),
                  .pairs = AllPairs(faces),
                  .goals = size.goals,
                  .with_rivals = true,
                  .rival_column = absl::StrCat("vertex, ", label)};
  RunSearchDuel(bench, state, duel);
  bench.figures.Add(
      MeasureError(duel.pairs)
          .ToFigure(absl::StrCat("error of the distances, ", label),
                    absl::StrCat("nanoflann in double; RMS of the pairs ", MeanRms(duel.pairs))));
  return absl::OkStatus();
}

/// The same among people who differ more than those that the goals were set with.
absl::Status MeasureDiverse(Bench& bench, benchmark::State& state) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.diverse_faces.Get(60'000, kMeshes));
  const std::vector<SearchPair> pairs = AllPairs(faces);
  RunSearchDuel(
      bench, state,
      {.name = absl::StrCat("diverse people (RMS ", MeanRms(pairs), "), 60k"), .pairs = pairs});
  return absl::OkStatus();
}

}  // namespace

void RegisterNearest(Bench& bench) {
  const int rounds = bench.options.IsQuick() ? 5 : 11;
  for (const Size& size : kSizes) {
    Register(bench, absl::StrCat("nearest/", size.vertices / 1000, "k"), rounds,
             [&size](Bench& b, benchmark::State& state) { return MeasureFaces(b, state, size); });
  }
  if (!bench.options.IsQuick() && bench.diverse_faces.MadeCount(60'000) > 0) {
    Register(bench, "nearest/60k/diverse", rounds, MeasureDiverse);
  }
}

}  // namespace cohort
