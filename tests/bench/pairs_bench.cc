#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/geometry/comparison/corresponded_rms.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/nearest/packet_search.h"
#include "tests/bench/bench.h"
#include "tests/bench/search_duel.h"

namespace cohort {
namespace {

constexpr int kMeshes = 4;

absl::Status MeasureMetrics(Bench& bench, benchmark::State& state, int vertices) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, kMeshes));
  const std::vector<SearchPair> pairs = AllPairs(faces);
  PacketSearch search;
  NearestSlots nearest;
  DistanceScratch scratch;
  Contest contest;
  contest.Add("search", static_cast<double>(pairs.size()), [&] {
    return SecondsOf([&] {
      for (const SearchPair& pair : pairs) {
        search.Find(pair.query->packed, pair.target->packed, nearest);
      }
    });
  });
  contest.Add("pair", static_cast<double>(pairs.size()), [&] {
    return SecondsOf([&] {
      for (const SearchPair& pair : pairs) {
        search.Find(pair.query->packed, pair.target->packed, nearest);
        const std::span<const float> squares(nearest.squared_distances.data(),
                                             static_cast<size_t>(pair.query->mesh.VertexCount()));
        benchmark::DoNotOptimize(MeasureSquaredDistances(squares, scratch));
      }
    });
  });
  contest.Run(state);
  bench.figures.Add({absl::StrCat("pair with all metrics and the sketch, ", vertices / 1000, "k"),
                     AtMost(1.15), contest.Ratio("pair", "search"), " x its search",
                     absl::StrCat(Digits(contest.Nanoseconds("pair") * 1e-6), " ms against ",
                                  Digits(contest.Nanoseconds("search") * 1e-6), " ms")});
  return absl::OkStatus();
}

constexpr int kManyMeshes = 60;
constexpr int kTileMeshes = 8;

/// A face that bends a little otherwise, in memory of its own.
BenchMesh Bent(const BenchMesh& face, uint64_t seed) {
  constexpr double kAmplitude = 0.7;  // mm, along each axis
  Random random(seed);
  TriangleMesh mesh = face.mesh;
  for (int axis = 0; axis < 3; ++axis) {
    const double wavelength = random.Uniform(60, 120);
    const double phase = random.Uniform(0, 2 * std::numbers::pi);
    const int along = static_cast<int>(random.Below(3));
    const Eigen::ArrayXd wave =
        (face.mesh.vertices.row(along).array() * (2 * std::numbers::pi / wavelength) + phase).sin();
    mesh.vertices.row(axis) += kAmplitude * wave.matrix().transpose();
  }
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return BenchMesh(std::move(mesh));
}

/// 60 meshes in the order in which 8 x 8 tiles compare them. Of the tiles every `stride`th is done.
std::vector<SearchPair> TilePairs(std::span<const BenchMesh* const> meshes, int stride) {
  const int count = static_cast<int>(meshes.size());
  std::vector<SearchPair> pairs;
  int tile = 0;
  for (int row = 0; row < count; row += kTileMeshes) {
    for (int column = 0; column < count; column += kTileMeshes) {
      if (tile++ % stride != 0) {
        continue;
      }
      for (int i = row; i < std::min(row + kTileMeshes, count); ++i) {
        for (int j = column; j < std::min(column + kTileMeshes, count); ++j) {
          if (i != j) {
            pairs.push_back({meshes[static_cast<size_t>(i)], meshes[static_cast<size_t>(j)]});
          }
        }
      }
    }
  }
  return pairs;
}

absl::Status MeasureTiles(Bench& bench, benchmark::State& state, int vertices, double goal) {
  const int made = bench.faces.MadeCount(vertices);
  const bool all_different = !bench.options.IsQuick() || made >= kManyMeshes;
  const int distinct = all_different ? kManyMeshes : std::clamp(made, kMeshes, kManyMeshes);
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, distinct));
  std::vector<BenchMesh> bent;
  bent.reserve(kManyMeshes);
  std::vector<const BenchMesh*> meshes;
  for (size_t i = 0; i < kManyMeshes; ++i) {
    if (i < faces.size()) {
      meshes.push_back(&faces[i]);
    } else {
      bent.push_back(Bent(faces[i % faces.size()], i));
      meshes.push_back(&bent.back());
    }
  }
  const std::vector<SearchPair> pairs = TilePairs(meshes, bench.options.IsQuick() ? 21 : 1);
  PacketSearch search;
  NearestSlots nearest;
  const auto find = [&](const SearchPair& pair) {
    search.Find(pair.query->packed, pair.target->packed, nearest);
  };
  Contest contest;
  contest.Add("tiles", QueryCount(pairs),
              [&] { return SecondsOf([&] { std::for_each(pairs.begin(), pairs.end(), find); }); });
  // The same pairs, since some are harder than others, each once more right after itself.
  contest.Add("hot", QueryCount(pairs), [&] {
    double seconds = 0;
    for (const SearchPair& pair : pairs) {
      find(pair);
      seconds += SecondsOf([&] { find(pair); });
    }
    return seconds;
  });
  contest.Run(state);
  bench.figures.Add({absl::StrCat("60 meshes in tiles, ", vertices / 1000, "k"), AtMost(goal),
                     contest.Ratio("tiles", "hot"), " x the hot pair",
                     absl::StrCat(Digits(contest.Nanoseconds("tiles")), " ns a query against ",
                                  Digits(contest.Nanoseconds("hot")), "; ", faces.size(),
                                  " people, ", bent.size(), " bent copies")});
  return absl::OkStatus();
}

/// The matrix of all pairs over correspondences against both directions of each exact pair. Both
/// sides find each mesh made ready: its displacements rounded, its index built. What the rounding
/// takes is measured as well.
absl::Status MeasurePreview(Bench& bench, benchmark::State& state, int vertices) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, kMeshes));
  const std::vector<SearchPair> pairs = AllPairs(faces);
  Random random(1);
  std::vector<Eigen::Matrix3Xf> displacements;
  DisplacementFields fields(vertices);
  for (int mesh = 0; mesh < kManyMeshes; ++mesh) {
    const auto displacement = [&random] { return static_cast<float>(random.Uniform(-3, 3)); };
    displacements.emplace_back(Eigen::Matrix3Xf::NullaryExpr(3, vertices, displacement));
    fields.Add(displacements.back());
  }
  PacketSearch search;
  NearestSlots nearest;
  DistanceScratch scratch;
  Contest contest;
  contest.Add("rounding", kManyMeshes, [&] {
    return SecondsOf([&] {
      DisplacementFields rounded(vertices);
      for (const Eigen::Matrix3Xf& displacement : displacements) {
        rounded.Add(displacement);
      }
      benchmark::DoNotOptimize(rounded.Values(0).data());
    });
  });
  contest.Add("preview", kManyMeshes * (kManyMeshes - 1) / 2.0, [&] {
    return SecondsOf([&] { benchmark::DoNotOptimize(CorrespondedRms(fields, fields)); });
  });
  contest.Add("exact", static_cast<double>(pairs.size()) / 2, [&] {
    return SecondsOf([&] {
      for (const SearchPair& pair : pairs) {
        search.Find(pair.query->packed, pair.target->packed, nearest);
        const std::span<const float> squares(nearest.squared_distances.data(),
                                             static_cast<size_t>(pair.query->mesh.VertexCount()));
        benchmark::DoNotOptimize(MeasureSquaredDistances(squares, scratch));
      }
    });
  });
  contest.Run(state);
  bench.figures.Add(
      {absl::StrCat("preview matrix of 60 meshes, ", vertices / 1000, "k"), AtLeast(300),
       contest.Ratio("exact", "preview"), " x exact pairs a second",
       absl::StrCat(Digits(contest.Nanoseconds("preview") * 1e-3), " us a pair against ",
                    Digits(contest.Nanoseconds("exact") * 1e-3), " us; once ",
                    Digits(contest.Nanoseconds("rounding") * 1e-3), " us a mesh to round it")});
  return absl::OkStatus();
}

}  // namespace

void RegisterPairs(Bench& bench) {
  for (const int vertices : {10'000, 20'000, 60'000}) {
    Register(bench, absl::StrCat("metrics/", vertices / 1000, "k"),
             bench.options.IsQuick() ? 7 : 15, [vertices](Bench& b, benchmark::State& state) {
               return MeasureMetrics(b, state, vertices);
             });
  }
  const int rounds = bench.options.IsQuick() ? 3 : 5;
  Register(bench, "preview/20k", rounds,
           [](Bench& b, benchmark::State& state) { return MeasurePreview(b, state, 20'000); });
  Register(bench, "tiles/20k", rounds,
           [](Bench& b, benchmark::State& state) { return MeasureTiles(b, state, 20'000, 1.2); });
  Register(bench, "tiles/60k", rounds,
           [](Bench& b, benchmark::State& state) { return MeasureTiles(b, state, 60'000, 1.35); });
}

}  // namespace cohort
