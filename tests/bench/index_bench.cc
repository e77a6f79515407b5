#include <memory>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "tests/bench/bench.h"

namespace cohort {
namespace {

constexpr int kMeshes = 4;
constexpr double kMostShare = 0.6;

absl::Status MeasureBuild(Bench& bench, benchmark::State& state, int vertices) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, kMeshes));
  const NearestRivalKind base = NearestRivals().front();
  Contest contest;
  contest.Add(std::string(kBase), kMeshes, [&] {
    std::vector<std::unique_ptr<NearestRival>> built;
    return SecondsOf([&] {
      for (const BenchMesh& face : faces) {
        built.push_back(base.make(face.Points()));
      }
    });
  });
  contest.Add("ours", kMeshes, [&] {
    std::vector<std::unique_ptr<PackedMesh>> built;
    return SecondsOf([&] {
      for (const BenchMesh& face : faces) {
        built.push_back(std::make_unique<PackedMesh>(face.vertices));
      }
    });
  });
  contest.Run(state);
  bench.figures.Add({absl::StrCat("index build, ", vertices / 1000, "k"), AtMost(kMostShare),
                     contest.Ratio("ours", kBase), " x nanoflann's",
                     absl::StrCat(Digits(contest.Nanoseconds("ours") * 1e-6), " ms against ",
                                  Digits(contest.Nanoseconds(kBase) * 1e-6), " ms")});
  return absl::OkStatus();
}

}  // namespace

void RegisterIndex(Bench& bench) {
  for (const int vertices : {10'000, 20'000, 60'000}) {
    Register(
        bench, absl::StrCat("index/", vertices / 1000, "k"), 11,
        [vertices](Bench& b, benchmark::State& state) { return MeasureBuild(b, state, vertices); });
  }
}

}  // namespace cohort
