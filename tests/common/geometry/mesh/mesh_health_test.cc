#include "common/geometry/mesh/mesh_health.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::IsOk;
using testing::MakeMesh;
using testing::StatusIs;
using testing::Tetrahedron;
using testing::Together;
using testing::WavySheet;

constexpr double kRounding = 1e-9;

MeshHealth HealthOf(TriangleMesh mesh) {
  MeshHealth health;
  EXPECT_THAT(CheckAndClean(mesh, health), IsOk());
  return health;
}

TEST(CheckAndClean, LeavesAGoodMeshAsItIs) {
  const TriangleMesh original = Tetrahedron();
  TriangleMesh mesh = original;
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(mesh.vertices, original.vertices);
  EXPECT_EQ(mesh.faces, original.faces);
  EXPECT_EQ(health.vertices, 4);
  EXPECT_EQ(health.faces, 4);
  EXPECT_EQ(health.components, 1);
  EXPECT_EQ(health.largest_component_share, 1);
  EXPECT_EQ(health.boundary_share, 0);
  EXPECT_EQ(health.non_manifold_edges, 0);
  EXPECT_FALSE(health.point_cloud);
  EXPECT_THAT(health.warnings, IsEmpty());
}

TEST(CheckAndClean, MeasuresATetrahedron) {
  const MeshHealth health = HealthOf(Tetrahedron(100));
  EXPECT_NEAR(health.diagonal, 100 * std::sqrt(3.0), kRounding);
  // Three right triangles and one of side 100 sqrt(2).
  EXPECT_NEAR(health.surface_area, 3 * 5000 + std::sqrt(3.0) / 4 * 20000, 1e-6);
  // Centroid (25, 25, 25): distances squared 3 * 25^2 once and 75^2 + 2 * 25^2 three times.
  EXPECT_NEAR(health.rms_radius, std::sqrt((1875.0 + 3 * 6875.0) / 4), kRounding);
}

TEST(CheckAndClean, CountsTheBoundaryOfAnOpenSheet) {
  const int side = 11;
  const MeshHealth health = HealthOf(WavySheet(side));
  const double boundary = 4 * (side - 1);
  const double all = 3 * (side - 1) * (side - 1) + 2 * (side - 1);
  EXPECT_NEAR(health.boundary_share, boundary / all, kRounding);
}

TEST(CheckAndClean, RefusesANumberThatIsNotFinite) {
  TriangleMesh mesh = Tetrahedron();
  MeshHealth health;
  mesh.vertices(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "vertex 2: coordinate 1"));
  mesh.vertices(1, 2) = -std::numeric_limits<double>::infinity();
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "vertex 2: coordinate 1"));
}

TEST(CheckAndClean, RefusesACoordinateBeyondAMillion) {
  TriangleMesh mesh = Tetrahedron();
  MeshHealth health;
  mesh.vertices(0, 3) = -1.5e6;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "vertex 3: coordinate 0 is -1.5e+06"));
}

TEST(CheckAndClean, RefusesAnIndexOutOfRange) {
  TriangleMesh mesh = Tetrahedron();
  MeshHealth health;
  mesh.faces(2, 1) = 4;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "face 1 uses vertex 4 of 4"));
  mesh.faces(2, 1) = -1;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "face 1 uses vertex -1 of 4"));
}

TEST(CheckAndClean, RemovesFacesWithAVertexTwice) {
  TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}}, {{1, 1, 2}, {0, 1, 2}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.degenerate_faces, 1);
  ASSERT_EQ(mesh.FaceCount(), 1);
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(CheckAndClean, KeepsButCountsFacesWithoutArea) {
  TriangleMesh mesh =
      MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {25, 0, 0}}, {{0, 1, 2}, {0, 3, 1}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.degenerate_faces, 1);
  EXPECT_EQ(mesh.FaceCount(), 2);
}

TEST(CheckAndClean, RemovesDuplicateFacesWhicheverWayTheyRun) {
  TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {0, 0, 50}},
                               {{0, 1, 2}, {2, 0, 1}, {0, 3, 1}, {1, 0, 2}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.duplicate_faces, 2);
  EXPECT_EQ(health.non_manifold_edges, 0);
  ASSERT_EQ(mesh.FaceCount(), 2);
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh.faces.col(1), Eigen::Vector3i(0, 3, 1));
}

TEST(CheckAndClean, RemovesUnreferencedVerticesInOrder) {
  TriangleMesh mesh =
      MakeMesh({{9, 9, 9}, {0, 0, 0}, {50, 0, 0}, {8, 8, 8}, {0, 50, 0}}, {{1, 2, 4}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.vertices, 5);
  EXPECT_EQ(health.unreferenced_vertices, 2);
  ASSERT_EQ(mesh.VertexCount(), 3);
  EXPECT_EQ(mesh.vertices.col(1), Eigen::Vector3d(50, 0, 0));
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(CheckAndClean, KeepsButCountsDuplicateVertices) {
  TriangleMesh mesh =
      MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {50, 0, 0}, {-0.0, 50, 0}, {9, 9, 9}},
               {{0, 1, 2}, {3, 5, 4}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.duplicate_vertices, 2);
  EXPECT_EQ(mesh.VertexCount(), 6);
  EXPECT_THAT(health.warnings, Contains(HasSubstr("2 vertices lie exactly on earlier ones")));
}

TEST(CheckAndClean, CountsAnEdgeOfThreeFaces) {
  const MeshHealth health =
      HealthOf(MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {0, -50, 0}, {0, 0, 50}},
                        {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  EXPECT_EQ(health.non_manifold_edges, 1);
  EXPECT_THAT(health.warnings, Contains(HasSubstr("1 edges are not manifold")));
}

TEST(CheckAndClean, CountsAnEdgeUsedTwiceOneWay) {
  const MeshHealth health =
      HealthOf(MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {0, -50, 0}}, {{0, 1, 2}, {0, 1, 3}}));
  EXPECT_EQ(health.non_manifold_edges, 1);
}

TEST(CheckAndClean, CountsComponents) {
  const TriangleMesh sheet = WavySheet(10);
  const MeshHealth health = HealthOf(Together(Tetrahedron(30), sheet, {100, 0, 0}));
  EXPECT_EQ(health.components, 2);
  EXPECT_NEAR(health.largest_component_share, 162.0 / 166, kRounding);
  EXPECT_THAT(health.warnings,
              Contains(HasSubstr("2 components; the largest has 97.5 % of the faces")));
}

TEST(CheckAndClean, ConnectsByVerticesNotOnlyByEdges) {
  const MeshHealth health = HealthOf(MakeMesh(
      {{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {-50, 0, 0}, {0, -50, 0}}, {{0, 1, 2}, {0, 3, 4}}));
  EXPECT_EQ(health.components, 1);
}

TEST(CheckAndClean, AcceptsAPointCloud) {
  TriangleMesh cloud = WavySheet(10);
  cloud.faces.resize(3, 0);
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(cloud, health), IsOk());
  EXPECT_TRUE(health.point_cloud);
  EXPECT_EQ(cloud.VertexCount(), 100);
  EXPECT_EQ(health.unreferenced_vertices, 0);
  EXPECT_EQ(health.surface_area, 0);
  EXPECT_THAT(health.warnings, Contains(HasSubstr("point cloud")));
}

TEST(CheckAndClean, RefusesAnEmptyMesh) {
  TriangleMesh mesh;
  MeshHealth health;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "only 0 usable vertices"));
}

TEST(CheckAndClean, RefusesACloudOfTwoPoints) {
  TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}}, {});
  MeshHealth health;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "only 2 usable vertices"));
}

TEST(CheckAndClean, RefusesAMeshWithoutOneUsableFace) {
  TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}}, {{0, 1, 1}, {2, 2, 2}});
  MeshHealth health;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "none of the 2 faces"));
}

TEST(CheckAndClean, RefusesPointsThatAllCoincide) {
  TriangleMesh mesh = MakeMesh({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{0, 1, 2}});
  MeshHealth health;
  EXPECT_THAT(CheckAndClean(mesh, health),
              StatusIs(absl::StatusCode::kInvalidArgument, "all 3 vertices are at the same point"));
}

TEST(CheckAndClean, AsksForTheUnitOfASmallMesh) {
  EXPECT_THAT(HealthOf(Tetrahedron(0.25)).warnings,
              Contains("largest extent is 0.25: metres? Cohort assumes millimetres"));
  EXPECT_THAT(HealthOf(Tetrahedron(8)).warnings,
              Contains("largest extent is 8: centimetres or inches? Cohort assumes millimetres"));
  EXPECT_THAT(HealthOf(Tetrahedron(150000)).warnings,
              Contains("largest extent is 150000: micrometres? Cohort assumes millimetres"));
  EXPECT_THAT(HealthOf(Tetrahedron(1e-4)).warnings, Contains(HasSubstr("another unit?")));
  EXPECT_THAT(HealthOf(Tetrahedron(12)).warnings, IsEmpty());
  EXPECT_THAT(HealthOf(Tetrahedron(570)).warnings, IsEmpty());
}

TEST(CheckAndClean, WarnsFarFromTheOrigin) {
  TriangleMesh mesh = Tetrahedron(30);
  mesh.vertices.row(0).array() += 5e5;
  EXPECT_THAT(HealthOf(mesh).warnings, Contains(HasSubstr("far from the origin")));
}

TEST(CheckAndClean, WarnsOfManyBoundaryEdges) {
  EXPECT_THAT(HealthOf(MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}}, {{0, 1, 2}})).warnings,
              Contains(HasSubstr("100 % of the edges are boundary")));
}

TEST(CheckAndClean, StartsFromAFreshReport) {
  MeshHealth health;
  health.degenerate_faces = 7;
  health.warnings.emplace_back("old");
  TriangleMesh mesh = Tetrahedron();
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.degenerate_faces, 0);
  EXPECT_THAT(health.warnings, IsEmpty());
}

TEST(CheckAndClean, FindsNothingNewTheSecondTime) {
  TriangleMesh mesh = MakeMesh({{9, 9, 9}, {0, 0, 0}, {50, 0, 0}, {8, 8, 8}, {0, 50, 0}},
                               {{1, 2, 4}, {2, 4, 1}, {3, 3, 1}});
  MeshHealth health;
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  ASSERT_THAT(CheckAndClean(mesh, health), IsOk());
  EXPECT_EQ(health.degenerate_faces + health.duplicate_faces + health.unreferenced_vertices, 0);
}

/// Few vertices on few whole numbers: every kind of trouble is common.
TriangleMesh RandomTrouble(Random& random) {
  TriangleMesh mesh;
  const int64_t vertices = 4 + random.Below(12);
  mesh.vertices.resize(3, vertices);
  for (double& coordinate : mesh.vertices.reshaped()) {
    coordinate = 50.0 * static_cast<double>(random.Below(3));
  }
  mesh.faces.resize(3, 1 + random.Below(14));
  for (int32_t& vertex : mesh.faces.reshaped()) {
    vertex = static_cast<int32_t>(random.Below(vertices));
  }
  return mesh;
}

/// The same numbers by comparing everything with everything.
struct BruteForce {
  /// Start and end of an edge as a face runs along it -> number of such faces.
  using DirectedEdges = std::map<std::pair<int32_t, int32_t>, int>;

  explicit BruteForce(const TriangleMesh& mesh) {
    CountFacesAndEdges(mesh);
    CountDuplicateVertices(mesh);
  }

  void CountFacesAndEdges(const TriangleMesh& mesh) {
    std::set<std::set<int32_t>> seen;
    DirectedEdges uses;
    for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
      const Eigen::Vector3i face = mesh.faces.col(f);
      const std::set<int32_t> corners(face.begin(), face.end());
      if (corners.size() == 3 && seen.insert(corners).second) {
        for (int corner = 0; corner < 3; ++corner) {
          ++uses[{face[corner], face[(corner + 1) % 3]}];
        }
      }
      duplicate_faces += corners.size() == 3 ? 1 : 0;
    }
    duplicate_faces -= static_cast<int64_t>(seen.size());
    components = CountComponents(seen);
    CountEdges(uses);
  }

  void CountEdges(const DirectedEdges& uses) {
    for (const auto& [edge, forward] : uses) {
      const auto opposite = uses.find({edge.second, edge.first});
      const int backward = opposite == uses.end() ? 0 : opposite->second;
      const bool counted_from_the_other_side = backward > 0 && edge.first > edge.second;
      edges += counted_from_the_other_side ? 0 : 1;
      boundary += forward + backward == 1 ? 1 : 0;
      non_manifold += !counted_from_the_other_side && (forward > 1 || backward > 1) ? 1 : 0;
    }
  }

  void CountDuplicateVertices(const TriangleMesh& mesh) {
    for (int64_t v = 0; v < mesh.VertexCount(); ++v) {
      bool duplicate = false;
      for (int64_t w = 0; w < v; ++w) {
        duplicate = duplicate || mesh.vertices.col(v) == mesh.vertices.col(w);
      }
      duplicate_vertices += duplicate ? 1 : 0;
    }
  }

  static int64_t CountComponents(const std::set<std::set<int32_t>>& faces) {
    std::vector<std::set<int32_t>> pieces;
    for (const std::set<int32_t>& face : faces) {
      std::set<int32_t> merged = face;
      for (auto piece = pieces.begin(); piece != pieces.end();) {
        const bool touches =
            std::any_of(face.begin(), face.end(), [&](int32_t v) { return piece->count(v) > 0; });
        if (touches) {
          merged.insert(piece->begin(), piece->end());
          piece = pieces.erase(piece);
        } else {
          ++piece;
        }
      }
      pieces.push_back(merged);
    }
    return static_cast<int64_t>(pieces.size());
  }

  int64_t duplicate_vertices = 0;
  int64_t duplicate_faces = 0;
  int64_t edges = 0;
  int64_t boundary = 0;
  int64_t non_manifold = 0;
  int64_t components = 0;
};

TEST(CheckAndClean, AgreesWithBruteForce) {
  Random random(11);
  int accepted = 0;
  for (int round = 0; round < 2000; ++round) {
    TriangleMesh mesh = RandomTrouble(random);
    const BruteForce expected(mesh);
    MeshHealth health;
    if (!CheckAndClean(mesh, health).ok()) {
      continue;
    }
    ++accepted;
    ASSERT_EQ(health.duplicate_vertices, expected.duplicate_vertices) << round;
    ASSERT_EQ(health.duplicate_faces, expected.duplicate_faces) << round;
    ASSERT_EQ(health.non_manifold_edges, expected.non_manifold) << round;
    ASSERT_EQ(health.components, expected.components) << round;
    ASSERT_NEAR(health.boundary_share,
                static_cast<double>(expected.boundary) / static_cast<double>(expected.edges),
                kRounding)
        << round;
  }
  EXPECT_GT(accepted, 1500);
}

}  // namespace
}  // namespace cohort
