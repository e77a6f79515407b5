#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace cohort {

/// n points as x0 y0 z0 x1 y1 z1 ... in the caller's memory.
///
/// Plain memory, because rivals are compiled with -march=native, which ours are not: Eigen's types
/// must not cross that border.
struct PointList {
  const double* xyz = nullptr;
  int64_t count = 0;
};

/// Three vertices a triangle, in the caller's memory.
struct TriangleList {
  const int32_t* corners = nullptr;
  int64_t count = 0;
};

/// Finds nearest vertices of one target, one query after the other.
class NearestRival {
 public:
  virtual ~NearestRival() = default;
  /// @param nearest, squared_distances  one slot for each query.
  virtual void Find(PointList queries, int32_t* nearest, double* squared_distances) const = 0;
};

struct NearestRivalKind {
  std::string_view name;
  /// Builds the index. `vertices` must live as long as the rival.
  std::unique_ptr<NearestRival> (*make)(PointList vertices);
};

/// Finds distances to one target's surface.
class SurfaceRival {
 public:
  virtual ~SurfaceRival() = default;
  virtual void Find(PointList queries, double* squared_distances) const = 0;
};

struct SurfaceRivalKind {
  std::string_view name;
  std::unique_ptr<SurfaceRival> (*make)(PointList vertices, TriangleList triangles);
};

/// What one pass of scaling ICP sums over pairs of a source point a and its nearest target point b.
struct RivalSums {
  double count = 0;
  std::array<double, 3> a{};
  std::array<double, 3> b{};
  std::array<double, 9> ba{};  ///< b a^T, row by row.
  double aa = 0;
  double bb = 0;
  double squared_distance = 0;
};

/// Plain ICP's look-ups on nanoflann (double, leaf 10).
class IcpRival {
 public:
  virtual ~IcpRival() = default;
  /// @param transform  3 x 4, row by row: where the source is when nearest points are looked up.
  [[nodiscard]] virtual RivalSums Pass(PointList source,
                                       const std::array<double, 12>& transform) const = 0;
};
[[nodiscard]] std::unique_ptr<IcpRival> MakeIcpRival(PointList target);

/// All that were found when this was built; the first is BASE: nanoflann, double, leaf 10, in the
/// order of the file.
inline constexpr std::string_view kBase = "nanoflann";
[[nodiscard]] std::vector<NearestRivalKind> NearestRivals();
inline constexpr std::string_view kEmbree = "Embree";
inline constexpr std::string_view kCgal = "CGAL";
[[nodiscard]] std::vector<SurfaceRivalKind> SurfaceRivals();

}  // namespace cohort
