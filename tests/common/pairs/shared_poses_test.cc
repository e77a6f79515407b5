#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/geometry/io/read_mesh.h"
#include "common/pairs/align_mesh.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::DegreesBetween;
using testing::IsOk;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kPoses = 5;  // Errors of memory show in a few; a hundred take minutes.
#else
constexpr int kPoses = 100;
#endif

/// The meshes of a folder of ../shared/data, by name; empty if this checkout stands alone.
std::vector<TriangleMesh> SharedMeshes(const std::string& folder) {
  const fs::path path = fs::path(COHORT_SOURCE_DIR "/../shared/data") / folder;
  std::vector<fs::path> files;
  if (fs::exists(path)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      const fs::path extension = entry.path().extension();
      if (extension == ".ply" || extension == ".obj" || extension == ".stl") {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<TriangleMesh> meshes;
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    absl::StatusOr<TriangleMesh> mesh = ReadMesh(bytes, file.filename().string());
    EXPECT_THAT(mesh, IsOk());
    meshes.push_back(mesh.ok() ? *std::move(mesh) : TriangleMesh());
  }
  return meshes;
}

class SharedPoses : public ::testing::TestWithParam<const char*> {};

/// However a scan was held, it is aligned as it is in its own pose.
TEST_P(SharedPoses, AllComeBack) {
  const std::vector<TriangleMesh> meshes = SharedMeshes(GetParam());
  if (meshes.empty()) {
    GTEST_SKIP() << "../shared/data/" << GetParam() << " is not there";
  }
  Random random(2026);
  for (int i = 0; i < kPoses; ++i) {
    const size_t source = static_cast<size_t>(i) % meshes.size();
    const size_t target =
        (source + 1 + static_cast<size_t>(i) / meshes.size() % (meshes.size() - 1)) % meshes.size();
    Similarity motion;
    motion.rotation = testing::RandomRotation(random);
    motion.translation << random.Uniform(-500, 500), random.Uniform(-500, 500),
        random.Uniform(-500, 500);
    TriangleMesh moved = meshes[source];
    moved.vertices = motion.Apply(moved.vertices);
    const auto direct = AlignMeshTo(meshes[source], meshes[target], JobSpec());
    const auto turned = AlignMeshTo(moved, meshes[target], JobSpec());
    ASSERT_THAT(direct, IsOk());
    ASSERT_THAT(turned, IsOk());
    const double degrees = DegreesBetween(turned->T_target_source.rotation * motion.rotation,
                                          direct->T_target_source.rotation);
    EXPECT_LT(degrees, 0.5) << "mesh " << source << " to mesh " << target << ", RMS "
                            << turned->rms_residual << " against " << direct->rms_residual;
  }
}

INSTANTIATE_TEST_SUITE_P(Sets,
                         SharedPoses,
                         ::testing::Values("sets/faces_4x2_10k",
                                           "sets/faces_rough_4x2_5k",
                                           "real/facefuns12",
                                           "bones/femur12"));

}  // namespace
}  // namespace cohort
