#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/io/draco_codec.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/mesh_health.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;

/// All meshes beside the checkout, or none.
std::vector<std::filesystem::path> SharedMeshes() {
  const std::filesystem::path root = std::filesystem::path(COHORT_SOURCE_DIR) / "../shared";
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"data/sets", "data/real", "data/bones", "golden"}) {
    if (!std::filesystem::exists(root / folder)) {
      continue;
    }
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".obj" || extension == ".ply" || extension == ".stl") {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

struct Counts {
  int64_t vertices = -1;  ///< -1: the file does not say.
  int64_t faces = 0;
};

Counts StlCounts(const std::string& bytes) {
  Counts counts;
  if (bytes.compare(0, 5, "solid") != 0) {
    uint32_t triangles = 0;
    std::memcpy(&triangles, bytes.data() + 80, sizeof(triangles));
    counts.faces = triangles;
    return counts;
  }
  std::istringstream lines(bytes);
  for (std::string line; std::getline(lines, line);) {
    counts.faces += line.find("endfacet") != std::string::npos ? 1 : 0;
  }
  return counts;
}

Counts PlyCounts(const std::string& bytes) {
  Counts counts;
  std::istringstream lines(bytes);
  for (std::string line; std::getline(lines, line) && line.rfind("end_header", 0) != 0;) {
    if (line.rfind("element vertex ", 0) == 0) {
      counts.vertices = std::stoll(line.substr(15));
    } else if (line.rfind("element face ", 0) == 0) {
      counts.faces = std::stoll(line.substr(13));
    }
  }
  return counts;
}

Counts ObjCounts(const std::string& bytes) {
  Counts counts;
  counts.vertices = 0;
  std::istringstream lines(bytes);
  for (std::string line; std::getline(lines, line);) {
    counts.vertices += line.rfind("v ", 0) == 0 ? 1 : 0;
    counts.faces += line.rfind("f ", 0) == 0 ? 1 : 0;
  }
  return counts;
}

/// Counted the plain way, by another road than the readers'; all shared files are triangles.
Counts PlainCounts(const std::filesystem::path& path, const std::string& bytes) {
  return path.extension() == ".stl"   ? StlCounts(bytes)
         : path.extension() == ".ply" ? PlyCounts(bytes)
                                      : ObjCounts(bytes);
}

TEST(SharedData, AllReadWithTheRightCountsAndSurviveDraco) {
  const std::vector<std::filesystem::path> files = SharedMeshes();
  if (files.empty()) {
    GTEST_SKIP() << "no meshes in " << COHORT_SOURCE_DIR << "/../shared";
  }
  for (const std::filesystem::path& path : files) {
    SCOPED_TRACE(path);
    const std::string bytes = ReadFile(path);
    auto mesh = ReadMesh(bytes, path.filename().string());
    ASSERT_THAT(mesh, IsOk());
    const Counts counts = PlainCounts(path, bytes);
    EXPECT_EQ(mesh->FaceCount(), counts.faces);
    if (counts.vertices >= 0) {
      EXPECT_EQ(mesh->VertexCount(), counts.vertices);
    }
    MeshHealth health;
    ASSERT_THAT(CheckAndClean(*mesh, health), IsOk());
    EXPECT_GT(health.diagonal, 50);
    EXPECT_LT(health.diagonal, 1000);
    const auto encoded = EncodeDraco(*mesh);
    ASSERT_THAT(encoded, IsOk());
    const auto decoded = DecodeDraco(*encoded);
    ASSERT_THAT(decoded, IsOk());
    EXPECT_EQ(decoded->FaceCount(), mesh->FaceCount());
    EXPECT_GE(decoded->VertexCount(), mesh->VertexCount());
    const Bounds before = BoundsOf(mesh->vertices);
    const Bounds after = BoundsOf(decoded->vertices);
    EXPECT_LT((before.low - after.low).cwiseAbs().maxCoeff(), 0.001);
    EXPECT_LT((before.high - after.high).cwiseAbs().maxCoeff(), 0.001);
  }
}

}  // namespace
}  // namespace cohort
