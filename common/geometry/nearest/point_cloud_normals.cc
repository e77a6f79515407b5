#include "common/geometry/nearest/point_cloud_normals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <tuple>
#include <vector>

#include <Eigen/Eigenvalues>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/nearest/vertex_neighbourhood.h"

namespace cohort {
namespace {

/// A sum smaller than this share of its terms' sizes says nothing.
constexpr double kUndecidedShare = 1e-9;

struct GraphEdge {
  double weight;
  int32_t a;
  int32_t b;
  friend bool operator<(const GraphEdge& x, const GraphEdge& y) {
    return std::tie(x.weight, x.a, x.b) < std::tie(y.weight, y.a, y.b);
  }
};

/// Pieces of a growing forest; each member knows whether its normal is turned against that of the
/// root. Roots are the lowest members, so that nothing depends on the order of the unions.
class SignedPieces {
 public:
  explicit SignedPieces(Eigen::Index count)
      : parent_(static_cast<size_t>(count)), turned_(parent_.size(), 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  struct Place {
    int32_t root;
    uint8_t turned;  ///< 1: against the root.
  };

  Place Find(int32_t vertex) {
    int32_t root = vertex;
    uint8_t turned = 0;
    while (parent_[static_cast<size_t>(root)] != root) {
      turned ^= turned_[static_cast<size_t>(root)];
      root = parent_[static_cast<size_t>(root)];
    }
    // Everything on the way now hangs on the root itself.
    uint8_t rest = turned;
    for (int32_t at = vertex; at != root;) {
      const auto i = static_cast<size_t>(at);
      at = parent_[i];
      parent_[i] = root;
      const uint8_t own = turned_[i];
      turned_[i] = rest;
      rest ^= own;
    }
    return {.root = root, .turned = turned};
  }

  /// Joins the pieces of a and b; `opposed`: the normals as they are point against each other.
  void Join(int32_t a, int32_t b, uint8_t opposed) {
    const Place at_a = Find(a);
    const Place at_b = Find(b);
    if (at_a.root == at_b.root) {
      return;
    }
    const auto high = static_cast<size_t>(std::max(at_a.root, at_b.root));
    parent_[high] = std::min(at_a.root, at_b.root);
    turned_[high] = at_a.turned ^ at_b.turned ^ opposed;
  }

 private:
  std::vector<int32_t> parent_;
  std::vector<uint8_t> turned_;
};

/// Least principal axis of these vertices, its largest component positive; 0 if they coincide.
Eigen::Vector3d LeastAxis(const Eigen::Matrix3Xd& vertices, const std::vector<NearVertex>& near) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const NearVertex& neighbour : near) {
    mean += vertices.col(neighbour.vertex);
  }
  mean /= static_cast<double>(near.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const NearVertex& neighbour : near) {
    const Eigen::Vector3d offset = vertices.col(neighbour.vertex) - mean;
    covariance += offset * offset.transpose();
  }
  if (near.back().squared_distance == 0) {
    return Eigen::Vector3d::Zero();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  Eigen::Vector3d axis = eigen.eigenvectors().col(0);  // the least eigenvalue comes first
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis(largest) < 0 ? Eigen::Vector3d(-axis) : axis;
}

/// For each piece, by root: does the sum that tells outward ask for the other sign?
std::vector<uint8_t> PiecesToTurn(const Eigen::Matrix3Xd& vertices,
                                  const Eigen::Matrix3Xd& normals,
                                  const PointCloudNormalsOptions& options,
                                  SignedPieces& pieces) {
  const Eigen::Vector3d centroid = CentroidOf(vertices);
  std::vector<double> sum(static_cast<size_t>(vertices.cols()), 0);
  std::vector<double> size(sum.size(), 0);
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    const SignedPieces::Place place = pieces.Find(static_cast<int32_t>(v));
    const Eigen::Vector3d outward =
        options.view_direction ? *options.view_direction : vertices.col(v) - centroid;
    const double along = normals.col(v).dot(outward);
    sum[static_cast<size_t>(place.root)] += place.turned != 0 ? -along : along;
    size[static_cast<size_t>(place.root)] += outward.norm();
  }
  std::vector<uint8_t> turn(sum.size(), 0);
  for (size_t root = 0; root < sum.size(); ++root) {
    turn[root] = sum[root] < -kUndecidedShare * size[root] ? 1 : 0;
  }
  return turn;
}

}  // namespace

absl::Status PointCloudNormalsOptions::Validate() const {
  if (neighbours < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("normals of a point cloud: ", neighbours, " neighbours; a plane needs 3"));
  }
  if (view_direction && !(view_direction->allFinite() && view_direction->norm() > 0)) {
    return absl::InvalidArgumentError(
        "normals of a point cloud: the view direction must be finite and not zero");
  }
  return absl::OkStatus();
}

absl::StatusOr<Eigen::Matrix3Xd> PointCloudNormals(
    const Eigen::Ref<const Eigen::Matrix3Xd>& vertices, const PointCloudNormalsOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (vertices.cols() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("normals of a point cloud: ", vertices.cols(), " points; a plane needs 3"));
  }
  const auto neighbourhood = VertexNeighbourhood::Build(vertices);
  Eigen::Matrix3Xd normals(3, vertices.cols());
  std::vector<GraphEdge> edges;
  std::vector<NearVertex> near;
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    neighbourhood->Nearest(vertices.col(v), options.neighbours, near);
    normals.col(v) = LeastAxis(neighbourhood->Vertices(), near);
    for (const NearVertex& neighbour : near) {
      if (neighbour.vertex != v) {
        const auto vertex = static_cast<int32_t>(v);
        edges.push_back({.weight = 0,
                         .a = std::min(vertex, neighbour.vertex),
                         .b = std::max(vertex, neighbour.vertex)});
      }
    }
  }
  for (GraphEdge& edge : edges) {
    edge.weight = 1 - std::abs(normals.col(edge.a).dot(normals.col(edge.b)));
  }
  std::sort(edges.begin(), edges.end());

  SignedPieces pieces(vertices.cols());
  for (const GraphEdge& edge : edges) {  // Kruskal: cheapest first, pieces that meet are joined.
    pieces.Join(edge.a, edge.b, normals.col(edge.a).dot(normals.col(edge.b)) < 0 ? 1 : 0);
  }
  const std::vector<uint8_t> turn =
      PiecesToTurn(neighbourhood->Vertices(), normals, options, pieces);
  for (Eigen::Index v = 0; v < normals.cols(); ++v) {
    const SignedPieces::Place place = pieces.Find(static_cast<int32_t>(v));
    if ((place.turned ^ turn[static_cast<size_t>(place.root)]) != 0) {
      normals.col(v) = -normals.col(v);
    }
  }
  return normals;
}

}  // namespace cohort
