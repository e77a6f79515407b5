#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "tests/bench/bench.h"
#include "tests/bench/search_duel.h"

namespace cohort {
namespace {

constexpr size_t kMeshes = 4;
constexpr SearchGoals kUnlikeGoals = {9, 6, 0};

/// Meshes of a folder, centred, at most kMeshes.
absl::StatusOr<std::vector<BenchMesh>> ReadFolder(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".ply" || extension == ".obj" || extension == ".stl") {
      paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<BenchMesh> meshes;
  for (size_t i = 0; i < paths.size() && meshes.size() < kMeshes; ++i) {
    COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, ReadAsIngested(paths[i]));
    meshes.emplace_back(Centered(std::move(mesh)));
  }
  return meshes;
}

absl::Status MeasureFolder(Bench& bench,
                           benchmark::State& state,
                           const std::string& folder,
                           const std::string& name) {
  COHORT_ASSIGN_OR_RETURN(const auto meshes,
                          ReadFolder(absl::StrCat(bench.options.shared_data, "/", folder)));
  RunSearchDuel(bench, state,
                {.name = absl::StrCat("unlike shapes: ", name),
                 .pairs = AllPairs(meshes),
                 .goals = kUnlikeGoals});
  return absl::OkStatus();
}

absl::Status MeasureBonesAndFaces(Bench& bench, benchmark::State& state) {
  COHORT_ASSIGN_OR_RETURN(const auto bones,
                          ReadFolder(bench.options.shared_data + "/bones/femur12"));
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(10'000, kMeshes));
  std::vector<SearchPair> pairs;
  for (size_t i = 0; i < bones.size(); ++i) {
    pairs.push_back({&bones[i], &faces[i]});
    pairs.push_back({&faces[i], &bones[i]});
  }
  RunSearchDuel(bench, state,
                {.name = "unlike shapes: femur and face", .pairs = pairs, .goals = kUnlikeGoals});
  return absl::OkStatus();
}

/// Faces of 60k against faces moved away by `gap` mm.
absl::Status MeasureFarApart(Bench& bench, benchmark::State& state, double gap, SearchGoals goals) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(60'000, 3));
  std::vector<BenchMesh> moved;
  for (const BenchMesh& face : faces) {
    TriangleMesh mesh = face.mesh;
    mesh.vertices.row(2).array() += gap;
    mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
    moved.emplace_back(std::move(mesh));
  }
  std::vector<SearchPair> pairs;
  for (size_t i = 0; i < faces.size(); ++i) {
    pairs.push_back({&moved[i], &faces[(i + 1) % faces.size()]});
  }
  RunSearchDuel(bench, state,
                {.name = absl::StrCat("unlike shapes: 60k, ", gap, " mm apart"),
                 .pairs = pairs,
                 .goals = goals});
  return absl::OkStatus();
}

}  // namespace

void RegisterUnlike(Bench& bench) {
  const int rounds = bench.options.IsQuick() ? 3 : 11;
  if (std::filesystem::exists(bench.options.shared_data + "/bones/femur12")) {
    Register(bench, "unlike/femurs", rounds, [](Bench& b, benchmark::State& state) {
      return MeasureFolder(b, state, "bones/femur12", "femurs");
    });
    Register(bench, "unlike/femur_face", rounds, MeasureBonesAndFaces);
    Register(bench, "unlike/rough_faces", rounds, [](Bench& b, benchmark::State& state) {
      return MeasureFolder(b, state, "sets/faces_rough_4x2_5k", "rough faces, not aligned");
    });
  }
  Register(bench, "unlike/30mm", rounds, [](Bench& b, benchmark::State& state) {
    return MeasureFarApart(b, state, 30, kUnlikeGoals);
  });
  Register(bench, "unlike/100mm", rounds, [](Bench& b, benchmark::State& state) {
    return MeasureFarApart(b, state, 100, {0, 0, 0});
  });
}

}  // namespace cohort
