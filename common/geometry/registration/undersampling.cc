#include "common/geometry/registration/undersampling.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/geometry/mesh/curvature.h"
#include "common/geometry/mesh/edge_graph.h"
#include "common/geometry/nearest/vertex_neighbourhood.h"

namespace cohort {
namespace {

constexpr int64_t kFewestForAFit = 3;

std::vector<int32_t> AllVertices(int64_t count) {
  std::vector<int32_t> vertices(static_cast<size_t>(count));
  std::iota(vertices.begin(), vertices.end(), 0);
  return vertices;
}

size_t CountToKeep(int64_t vertices, const UndersamplingOptions& options) {
  const int64_t wanted = options.count > 0
                             ? options.count
                             : std::llround(options.share * static_cast<double>(vertices));
  return static_cast<size_t>(std::min(wanted, vertices));
}

std::vector<int32_t> SelectAtRandom(int64_t vertices, size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<int32_t> drawn = AllVertices(vertices);
  for (size_t i = 0; i < count; ++i) {
    const int64_t left = vertices - static_cast<int64_t>(i);
    std::swap(drawn[i], drawn[i + static_cast<size_t>(random.Below(left))]);
  }
  drawn.resize(count);
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

/// Distances along edges from the vertices kept so far, as far as the radius.
class KeptDistances {
 public:
  KeptDistances(const TriangleMesh& mesh, double radius)
      : vertices_(mesh.vertices),
        graph_(mesh),
        radius_(radius),
        distance_(static_cast<size_t>(mesh.VertexCount()),
                  std::numeric_limits<double>::infinity()) {}

  [[nodiscard]] double To(int32_t vertex) const { return distance_[static_cast<size_t>(vertex)]; }

  /// Dijkstra from one more vertex. It goes no further where another kept vertex is as near, since
  /// everything behind is nearer to that one too.
  void Keep(int32_t vertex) {
    Offer(vertex, 0);
    while (!queue_.empty()) {
      const auto [distance, v] = queue_.top();
      queue_.pop();
      if (distance > To(v)) {
        continue;  // a shorter way was found since
      }
      for (const int32_t neighbour : graph_.NeighboursOf(v)) {
        Offer(neighbour, distance + (vertices_.col(neighbour) - vertices_.col(v)).norm());
      }
    }
  }

 private:
  void Offer(int32_t vertex, double distance) {
    if (distance < radius_ && distance < To(vertex)) {
      distance_[static_cast<size_t>(vertex)] = distance;
      queue_.emplace(distance, vertex);
    }
  }

  using Entry = std::pair<double, int32_t>;
  const Eigen::Matrix3Xd& vertices_;
  EdgeGraph graph_;
  double radius_;
  std::vector<double> distance_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

std::vector<int32_t> SelectDisksOfMesh(const TriangleMesh& mesh, double radius) {
  KeptDistances distances(mesh, radius);
  std::vector<int32_t> kept;
  for (int32_t v = 0; v < mesh.VertexCount(); ++v) {
    if (distances.To(v) >= radius) {
      kept.push_back(v);
      distances.Keep(v);
    }
  }
  return kept;
}

std::vector<int32_t> SelectDisksOfCloud(const Eigen::Matrix3Xd& points, double radius) {
  const auto neighbourhood = VertexNeighbourhood::Build(points);
  std::vector<uint8_t> covered(static_cast<size_t>(points.cols()), 0);
  std::vector<int32_t> kept;
  std::vector<NearVertex> near;
  for (Eigen::Index v = 0; v < points.cols(); ++v) {
    if (covered[static_cast<size_t>(v)] != 0) {
      continue;
    }
    kept.push_back(static_cast<int32_t>(v));
    neighbourhood->Within(points.col(v), radius, near);
    for (const NearVertex& neighbour : near) {
      if (neighbour.squared_distance < radius * radius) {
        covered[static_cast<size_t>(neighbour.vertex)] = 1;
      }
    }
  }
  return kept;
}

std::vector<int32_t> SelectByCurvature(const TriangleMesh& mesh, size_t count) {
  const Eigen::VectorXd curvature = CurvaturesOf(mesh).maximum;
  std::vector<int32_t> order = AllVertices(mesh.VertexCount());
  std::stable_sort(order.begin(), order.end(),
                   [&curvature](int32_t a, int32_t b) { return curvature(a) > curvature(b); });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<int32_t> Select(const TriangleMesh& mesh, const UndersamplingOptions& options) {
  const size_t count = CountToKeep(mesh.VertexCount(), options);
  switch (options.method) {
    case UndersamplingMethod::kNone:
      break;
    case UndersamplingMethod::kRandom:
      return SelectAtRandom(mesh.VertexCount(), count, options.seed);
    case UndersamplingMethod::kDisk:
      return mesh.IsPointCloud() ? SelectDisksOfCloud(mesh.vertices, options.radius)
                                 : SelectDisksOfMesh(mesh, options.radius);
    case UndersamplingMethod::kCurvature:
      return SelectByCurvature(mesh, count);
  }
  return AllVertices(mesh.VertexCount());
}

}  // namespace

absl::Status UndersamplingOptions::Validate() const {
  const bool counts =
      method == UndersamplingMethod::kRandom || method == UndersamplingMethod::kCurvature;
  if (counts && (count < 0 || (count > 0 && count < kFewestForAFit))) {
    return absl::InvalidArgumentError(
        absl::StrCat("undersampling: count ", count, "; it must be 0 (use the share) or >= 3"));
  }
  if (counts && count == 0 && !(share > 0 && share <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("undersampling: share ", share, "; it must be in (0, 1]"));
  }
  if (method == UndersamplingMethod::kDisk && !(radius > 0 && std::isfinite(radius))) {
    return absl::InvalidArgumentError(
        absl::StrCat("undersampling: radius ", radius, "; it must be positive"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<int32_t>> SelectVertices(const TriangleMesh& mesh,
                                                    const UndersamplingOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (options.method == UndersamplingMethod::kCurvature && mesh.IsPointCloud()) {
    return absl::FailedPreconditionError(
        "undersampling by curvature: a point cloud has no surface; use random or disk");
  }
  std::vector<int32_t> kept = mesh.VertexCount() > 0 ? Select(mesh, options) : AllVertices(0);
  if (static_cast<int64_t>(kept.size()) < kFewestForAFit) {
    return absl::FailedPreconditionError(absl::StrCat("undersampling keeps ", kept.size(), " of ",
                                                      mesh.VertexCount(),
                                                      " vertices; a fit needs 3"));
  }
  return kept;
}

}  // namespace cohort
