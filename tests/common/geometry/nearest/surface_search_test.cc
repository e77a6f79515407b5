#include "common/geometry/nearest/surface_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/base/random.h"
#include "common/geometry/synthetic/demo_cohort.h"

namespace cohort {
namespace {

struct Surface {
  Eigen::Matrix3Xf vertices;
  Matrix3Xi faces;
};

enum class Shape {
  kFace,         ///< A scan.
  kGrid,         ///< A height field on whole numbers: nearly every distance is a tie.
  kPlane,        ///< Overlapping triangles in one plane.
  kNeedles,      ///< A millionth as wide as long.
  kDegenerate,   ///< Points, segments, repeated faces among triangles.
  kOneTriangle,  ///< Again and again.
  kScales,       ///< From 1e-24 to 1e12.
  kTiny,         ///< All of it where squares leave float32.
};
Eigen::Vector3f RandomPoint(Random& random, double range) {
  return Eigen::Vector3d(random.Uniform(-range, range), random.Uniform(-range, range),
                         random.Uniform(-range, range))
      .cast<float>();
}

Surface MakeFace(int faces, uint64_t seed) {
  DemoOptions options;
  options.people = 2;
  options.captures = 1;
  options.vertices = std::max(faces, 200);
  options.seed = seed;
  const TriangleMesh mesh = MakeDemoScan(options, 0, 0)->mesh;
  const Eigen::Vector3d middle = mesh.vertices.rowwise().mean();
  return {(mesh.vertices.colwise() - middle).cast<float>(), mesh.faces.leftCols(faces)};
}

Surface MakeGrid(int faces, uint64_t seed) {
  constexpr int kSide = 40;
  Random random(seed);
  Surface surface{Eigen::Matrix3Xf(3, kSide * kSide), Matrix3Xi(3, faces)};
  for (int i = 0; i < kSide * kSide; ++i) {
    surface.vertices.col(i) =
        Eigen::Vector3i(i % kSide, i / kSide, random.Below(2) == 0 ? 0 : 1).cast<float>();
  }
  for (int face = 0; face < faces; ++face) {
    const int cell = face / 2 % ((kSide - 1) * (kSide - 1));
    const int corner = cell / (kSide - 1) * kSide + cell % (kSide - 1);
    if (face % 2 == 0) {
      surface.faces.col(face) << corner, corner + 1, corner + kSide;
    } else {
      surface.faces.col(face) << corner + kSide + 1, corner + kSide, corner + 1;
    }
  }
  return surface;
}

/// Vertices 3 f, 3 f + 1, 3 f + 2 of each face f, to be filled.
Surface Unconnected(int faces) {
  Surface surface{Eigen::Matrix3Xf(3, 3 * faces), Matrix3Xi(3, faces)};
  for (int i = 0; i < 3 * faces; ++i) {
    surface.faces(i % 3, i / 3) = i;
  }
  return surface;
}

void FillTriangle(Shape shape, Random& random, Eigen::Ref<Eigen::Matrix3f> corners) {
  const Eigen::Vector3f from = RandomPoint(random, 80);
  const Eigen::Vector3f along = RandomPoint(random, 8);
  if (shape == Shape::kPlane) {
    corners << from, from + along, from + RandomPoint(random, 5);
    corners.row(2).setZero();
  } else if (shape == Shape::kNeedles) {
    const auto share = static_cast<float>(random.Uniform(-0.3, 1.3));
    corners << from, from + along, from + share * along + RandomPoint(random, 8e-6);
  } else if (shape == Shape::kDegenerate) {
    const int64_t kind = random.Below(4);
    corners << from, from, from;
    if (kind == 1) {
      corners.col(random.Below(3)) += along;
    } else if (kind == 2) {
      corners << from, from + 2 * along, from + along;
    } else if (kind == 3) {
      corners.col(1) += along;
      corners.col(2) += RandomPoint(random, 8);
    }
  } else if (shape == Shape::kOneTriangle) {
    corners << 0, 4, 1, 0, 1, 5, 2, 2, 3;
  } else {
    const double exponent = shape == Shape::kTiny ? -23 : random.Uniform(-24, 12);
    const auto scale = static_cast<float>(std::pow(10.0, exponent));
    corners << from * scale, (from + along) * scale, (from + RandomPoint(random, 8)) * scale;
  }
}

Surface MakeShape(Shape shape, int faces, uint64_t seed) {
  if (shape == Shape::kFace) {
    return MakeFace(faces, seed);
  }
  if (shape == Shape::kGrid) {
    return MakeGrid(faces, seed);
  }
  Random random(seed);
  Surface surface = Unconnected(faces);
  for (int face = 0; face < faces; ++face) {
    FillTriangle(shape, random, surface.vertices.middleCols<3>(Eigen::Index{3} * face));
    if (shape == Shape::kDegenerate && face > 0 && random.Below(4) == 0) {
      surface.faces.col(face) = surface.faces.col(random.Below(face)).reverse();
    }
  }
  return surface;
}

/// Half of them on or near the surface, half of them anywhere about it; on whole and half numbers
/// for the grid.
Eigen::Matrix3Xf MakeQueries(Shape shape, const Surface& surface, int count, uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3Xf queries(3, count);
  const double scale = shape == Shape::kTiny ? 1e-23 : 1;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f vertex = surface.vertices.col(random.Below(surface.vertices.cols()));
    if (shape == Shape::kGrid) {
      queries.col(i) << static_cast<float>(random.Below(80)) / 2,
          static_cast<float>(random.Below(80)) / 2, static_cast<float>(random.Below(9)) / 2;
    } else if (i % 4 == 0) {
      queries.col(i) = vertex;
    } else if (i % 4 == 1) {
      queries.col(i) = vertex + RandomPoint(random, 3 * scale);
    } else {
      queries.col(i) = RandomPoint(random, 100 * scale);
    }
  }
  return queries;
}

// The distance as surface_kernels_settle.h defines it, written once more.

struct Vector {
  double x, y, z;
};
Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vector operator*(const Vector& a, double t) {
  return {a.x * t, a.y * t, a.z * t};
}
double Dot(const Vector& a, const Vector& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}
Vector Cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector ToVector(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

Vector FromEdge(const Vector& p, const Vector& edge) {
  const double square = Dot(edge, edge);
  const double t = square > 0 ? std::clamp(Dot(p, edge) / square, 0.0, 1.0) : 0.0;
  return p - edge * t;
}

struct Nearest {
  double squared_distance = std::numeric_limits<double>::infinity();
  int32_t face = -1;
  Eigen::Vector3f point;
};

Nearest DefinedNearest(const Eigen::Vector3f& query, const Surface& surface, int32_t face) {
  std::array<Eigen::Vector3f, 3> corners;
  for (size_t i = 0; i < 3; ++i) {
    corners[i] = surface.vertices.col(surface.faces(static_cast<Eigen::Index>(i), face));
  }
  std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  });
  const Vector q = ToVector(query);
  const Vector a = ToVector(corners[0]);
  const Vector b = ToVector(corners[1]);
  const Vector c = ToVector(corners[2]);
  const Vector ab = b - a;
  const Vector ac = c - a;
  Vector offset = FromEdge(q - a, ab);
  for (const Vector& other : {FromEdge(q - a, ac), FromEdge(q - b, c - b)}) {
    offset = Dot(other, other) < Dot(offset, offset) ? other : offset;
  }
  const Vector normal = Cross(ab, ac);
  const double whole = Dot(normal, normal);
  const double at_c = Dot(Cross(ab, q - a), normal);
  const double at_b = Dot(Cross(q - a, ac), normal);
  if (std::min({whole - (at_b + at_c), at_b, at_c}) > 0) {
    offset = normal * (Dot(q - a, normal) / whole);
  }
  const Vector point = q - offset;
  return {Dot(offset, offset), face, Eigen::Vector3d(point.x, point.y, point.z).cast<float>()};
}

Nearest DefinedNearest(const Eigen::Vector3f& query, const Surface& surface) {
  Nearest nearest;
  for (int32_t face = 0; face < surface.faces.cols(); ++face) {
    const Nearest other = DefinedNearest(query, surface, face);
    if (other.squared_distance < nearest.squared_distance) {
      nearest = other;
    }
  }
  return nearest;
}

// The distance by another formula, in a longer format.

using Long3 = Eigen::Matrix<long double, 3, 1>;

long double DistanceToSegment(const Long3& q, const Long3& a, const Long3& b) {
  const long double square = (b - a).squaredNorm();
  const long double t = square > 0 ? std::clamp<long double>((q - a).dot(b - a) / square, 0, 1) : 0;
  return (q - a - t * (b - a)).norm();
}

/// Barycentric coordinates from the heights over two orthonormal axes of the plane.
long double DistanceToTriangle(const Eigen::Vector3f& query, const Surface& surface, int face) {
  const Long3 q = query.cast<long double>();
  const Long3 a = surface.vertices.col(surface.faces(0, face)).cast<long double>();
  const Long3 b = surface.vertices.col(surface.faces(1, face)).cast<long double>();
  const Long3 c = surface.vertices.col(surface.faces(2, face)).cast<long double>();
  const long double edges = std::min(
      {DistanceToSegment(q, a, b), DistanceToSegment(q, b, c), DistanceToSegment(q, c, a)});
  const Long3 normal = (b - a).cross(c - a);
  if (normal.isZero(0)) {
    return edges;
  }
  const Long3 z = normal.normalized();
  const auto left_of = [&](const Long3& from, const Long3& to) {
    return z.dot((to - from).cross(q - from)) >= 0;
  };
  const bool inside = left_of(a, b) && left_of(b, c) && left_of(c, a);
  return inside ? std::abs(z.dot(q - a)) : edges;
}

double TrueDistance(const Eigen::Vector3f& query, const Surface& surface) {
  long double least = std::numeric_limits<long double>::infinity();
  for (int face = 0; face < surface.faces.cols(); ++face) {
    least = std::min(least, DistanceToTriangle(query, surface, face));
  }
  return static_cast<double>(least);
}

/// What reference/performance.md section 7 allows.
double Tolerance(double distance) {
  return 2e-6 * distance + 1e-6;
}

/// Each slot's result is that of brute force over the definition, to the bit.
void ExpectDefined(const PackedMesh& queries,
                   const Eigen::Matrix3Xf& points,
                   const PackedSurface& target,
                   const Surface& surface,
                   const NearestOnSurface& nearest) {
  for (int slot = 0; slot < queries.SlotCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    const Eigen::Vector3f query = points.col(queries.VertexOfSlot()[s]);
    const Nearest expected = DefinedNearest(query, surface);
    const auto found = static_cast<size_t>(nearest.slots[s]);
    ASSERT_EQ(target.FaceOfSlot()[found], expected.face) << "slot " << slot;
    ASSERT_EQ(nearest.squared_distances[s], static_cast<float>(expected.squared_distance))
        << "slot " << slot;
    ASSERT_EQ(nearest.PointOfSlot(slot), expected.point) << "slot " << slot;
  }
}

/// Distances and points agree with an independent formula.
void ExpectTrue(const PackedMesh& queries,
                const Eigen::Matrix3Xf& points,
                const PackedSurface& target,
                const Surface& surface,
                const NearestOnSurface& nearest) {
  for (int slot = 0; slot < queries.VertexCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    const Eigen::Vector3f query = points.col(queries.VertexOfSlot()[s]);
    const double distance = TrueDistance(query, surface);
    ASSERT_NEAR(std::sqrt(double{nearest.squared_distances[s]}), distance, Tolerance(distance));
    // The point is rounded to float32, and is on the face named.
    const Eigen::Vector3f point = nearest.PointOfSlot(slot);
    const double rounding = 1e-7 * double{point.cwiseAbs().maxCoeff()} + 1e-6;
    ASSERT_NEAR((query.cast<double>() - point.cast<double>()).norm(), distance,
                rounding + Tolerance(distance));
    const int32_t face = target.FaceOfSlot()[static_cast<size_t>(nearest.slots[s])];
    ASSERT_LE(static_cast<double>(DistanceToTriangle(point, surface, face)), rounding);
  }
}

class SurfaceSearchPath : public ::testing::TestWithParam<std::tuple<InstructionSet, Shape>> {};

TEST_P(SurfaceSearchPath, FindsWhatBruteForceFinds) {
  const auto [set, shape] = GetParam();
  SurfaceSearch search(set);
  NearestOnSurface nearest;
  uint64_t seed = 1;
  for (const int queries_size : {1, 15, 16, 17, 300}) {
    for (const int face_count : {1, 15, 16, 17, 257, 1300}) {
      const Surface surface = MakeShape(shape, face_count, ++seed);
      const Eigen::Matrix3Xf points = MakeQueries(shape, surface, queries_size, ++seed);
      const PackedMesh queries(points);
      const PackedSurface target(surface.vertices, surface.faces);
      search.Find(queries, target, nearest);
      ExpectDefined(queries, points, target, surface, nearest);
    }
  }
}

TEST_P(SurfaceSearchPath, KeepsToTheTolerance) {
  const auto [set, shape] = GetParam();
  SurfaceSearch search(set);
  NearestOnSurface nearest;
  const Surface surface = MakeShape(shape, 600, 3);
  const Eigen::Matrix3Xf points = MakeQueries(shape, surface, 500, 4);
  const PackedMesh queries(points);
  const PackedSurface target(surface.vertices, surface.faces);
  search.Find(queries, target, nearest);
  ExpectTrue(queries, points, target, surface, nearest);
}

TEST_P(SurfaceSearchPath, FindsFromAfarAndBetweenUnlikeShapes) {
  const auto [set, shape] = GetParam();
  SurfaceSearch search(set);
  NearestOnSurface nearest;
  const Surface source = MakeShape(shape, 200, 5);
  const Eigen::Matrix3Xf points =
      source.vertices.leftCols(std::min<Eigen::Index>(200, source.vertices.cols())).colwise() +
      Eigen::Vector3f(900, -2000, 30);
  for (const Shape other : {Shape::kFace, Shape::kGrid, Shape::kNeedles, Shape::kScales}) {
    const Surface surface = MakeShape(other, 900, 6);
    const PackedMesh queries(points);
    const PackedSurface target(surface.vertices, surface.faces);
    search.Find(queries, target, nearest);
    ExpectDefined(queries, points, target, surface, nearest);
  }
}

PointTransform TurnAndShift() {
  const Eigen::Matrix3d turn =
      1.01 * Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  PointTransform transform{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      transform.rows[row][column] = turn(row, column);
    }
    transform.rows[row][3] = 1 - row;
  }
  return transform;
}

Eigen::Matrix3Xf Moved(const PointTransform& transform, const Eigen::Matrix3Xf& points) {
  Eigen::Matrix3Xf moved(3, points.cols());
  for (int i = 0; i < points.cols(); ++i) {
    for (int row = 0; row < 3; ++row) {
      const double* m = transform.rows[row];
      moved(row, i) =
          static_cast<float>(m[0] * double{points(0, i)} +
                             (m[1] * double{points(1, i)} + (m[2] * double{points(2, i)} + m[3])));
    }
  }
  return moved;
}

TEST_P(SurfaceSearchPath, FindsForMovedQueriesFromAnySeed) {
  const auto [set, shape] = GetParam();
  SurfaceSearch search(set);
  const Surface surface = MakeShape(shape, 777, 8);
  const Eigen::Matrix3Xf points = MakeQueries(shape, surface, 333, 7);
  const PackedMesh queries(points);
  const PackedSurface target(surface.vertices, surface.faces);
  const PointTransform transform = TurnAndShift();
  const Eigen::Matrix3Xf moved = Moved(transform, points);
  NearestOnSurface nearest;
  search.FindMoved(queries, transform, target, SearchSeed::kDescent, nearest);
  ExpectDefined(queries, moved, target, surface, nearest);
  Random random(3);
  for (size_t s = 0; s < nearest.slots.size(); ++s) {
    nearest.slots[s] = static_cast<int32_t>(random.Below(target.SlotCount()));
  }
  search.FindMoved(queries, transform, target, SearchSeed::kPrevious, nearest);
  ExpectDefined(queries, moved, target, surface, nearest);
  search.FindMoved(queries, transform, target, SearchSeed::kPrevious, nearest);
  ExpectDefined(queries, moved, target, surface, nearest);
}

INSTANTIATE_TEST_SUITE_P(All,
                         SurfaceSearchPath,
                         ::testing::Combine(::testing::ValuesIn(AvailableInstructionSets()),
                                            ::testing::Values(Shape::kFace,
                                                              Shape::kGrid,
                                                              Shape::kPlane,
                                                              Shape::kNeedles,
                                                              Shape::kDegenerate,
                                                              Shape::kOneTriangle,
                                                              Shape::kScales,
                                                              Shape::kTiny)));

TEST(SurfaceSearch, GivesTheSameBytesOnEveryPathForWholeFaces) {
  const Surface source = MakeFace(6000, 31);
  const Surface surface = MakeFace(7000, 32);
  const PackedMesh queries(source.vertices);
  const PackedSurface target(surface.vertices, surface.faces);
  NearestOnSurface first;
  SurfaceSearch(InstructionSet::kPortable).Find(queries, target, first);
  for (const InstructionSet set : AvailableInstructionSets()) {
    NearestOnSurface nearest;
    SurfaceSearch(set).Find(queries, target, nearest);
    for (size_t s = 0; s < first.slots.size(); ++s) {
      ASSERT_EQ(nearest.slots[s], first.slots[s]);
      ASSERT_EQ(std::bit_cast<uint32_t>(nearest.squared_distances[s]),
                std::bit_cast<uint32_t>(first.squared_distances[s]));
    }
    for (size_t i = 0; i < first.points.size(); ++i) {
      ASSERT_EQ(std::bit_cast<uint32_t>(nearest.points[i]),
                std::bit_cast<uint32_t>(first.points[i]));
    }
  }
}

TEST(SurfaceSearch, IsNeverFartherThanTheNearestVertex) {
  const Surface source = MakeFace(3000, 33);
  const Surface surface = MakeFace(5000, 34);
  Eigen::Matrix3Xf corners(3, surface.faces.size());
  for (Eigen::Index i = 0; i < surface.faces.size(); ++i) {
    corners.col(i) = surface.vertices.col(surface.faces(i));
  }
  const PackedMesh queries(source.vertices);
  NearestSlots vertices;
  NearestOnSurface nearest;
  PacketSearch().Find(queries, PackedMesh(corners), vertices);
  SurfaceSearch().Find(queries, PackedSurface(surface.vertices, surface.faces), nearest);
  for (size_t s = 0; s < vertices.slots.size(); ++s) {
    ASSERT_LE(nearest.squared_distances[s], vertices.squared_distances[s] * (1 + 1e-6F));
  }
}

TEST(SurfaceSearch, MeasuresASingleTriangleInEveryRegion) {
  Eigen::Matrix3Xf vertices(3, 3);
  vertices << 0, 4, 0, 0, 0, 3, 0, 0, 0;
  Matrix3Xi faces(3, 1);
  faces << 0, 1, 2;
  Eigen::Matrix3Xf points(3, 7);
  points << 1, 2, 4, -3, -2, 7, -4,  // x
      1, -5, 3, 1, -2, -4, 6,        // y
      2, 0, 0, 4, 1, 0, 0;           // z
  Eigen::Matrix3Xf expected(3, 7);
  expected << 1, 2, 2.56F, 0, 0, 4, 0, 1, 0, 1.08F, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0;
  const PackedMesh queries(points);
  NearestOnSurface nearest;
  SurfaceSearch().Find(queries, PackedSurface(vertices, faces), nearest);
  for (int slot = 0; slot < 7; ++slot) {
    const int32_t vertex = queries.VertexOfSlot()[static_cast<size_t>(slot)];
    EXPECT_TRUE(nearest.PointOfSlot(slot).isApprox(expected.col(vertex), 1e-6F)) << vertex;
    EXPECT_FLOAT_EQ(nearest.squared_distances[static_cast<size_t>(slot)],
                    (points.col(vertex) - expected.col(vertex)).squaredNorm());
  }
}

}  // namespace
}  // namespace cohort
