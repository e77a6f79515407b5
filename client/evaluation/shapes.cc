#include "client/evaluation/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/pairs/align_mesh.h"
#include "common/pairs/pair_mesh.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

PackedMesh Packed(const TriangleMesh& mesh, const Eigen::Vector3d& center) {
  return PackedMesh(PlaceVertices(mesh, Similarity{}, center));
}

double DirectedRms(const PackedMesh& from, const PackedMesh& to) {
  PacketSearch search;
  NearestSlots nearest;
  search.Find(from, to, nearest);
  const MetricValues metrics =
      ComputeMetrics({nearest.squared_distances.data(), static_cast<size_t>(from.VertexCount())});
  return metrics[static_cast<size_t>(Metric::kRms)];
}

/// Positions by value, ascending.
std::vector<size_t> SortedPositions(std::span<const double> values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return values[a] < values[b]; });
  return order;
}

std::vector<double> Ranks(std::span<const double> values) {
  const std::vector<size_t> order = SortedPositions(values);
  std::vector<double> ranks(values.size());
  for (size_t first = 0; first < order.size();) {
    size_t end = first;
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    for (size_t i = first; i < end; ++i) {
      ranks[order[i]] = static_cast<double>(first + end - 1) / 2;
    }
    first = end;
  }
  return ranks;
}

}  // namespace

double ShapeDistance(const TriangleMesh& a, const TriangleMesh& b) {
  const Eigen::Vector3d center = b.vertices.rowwise().mean();
  const PackedMesh packed_a = Packed(a, center);
  const PackedMesh packed_b = Packed(b, center);
  return (DirectedRms(packed_a, packed_b) + DirectedRms(packed_b, packed_a)) / 2;
}

absl::StatusOr<TriangleMesh> MovedOnto(const TriangleMesh& a, const TriangleMesh& b) {
  COHORT_ASSIGN_OR_RETURN(const Alignment alignment, AlignMeshTo(a, b, JobSpec{}));
  return TriangleMesh{.vertices = alignment.T_target_source.Apply(a.vertices), .faces = a.faces};
}

absl::StatusOr<VariationMap> FetchVariation(Session& session, const JobId& job) {
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, session.GetOutputs(job));
  COHORT_ASSIGN_OR_RETURN(const std::string mesh, session.Blobs().Get(outputs.mean_shape));
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(outputs.summary));
  VariationMap map;
  COHORT_ASSIGN_OR_RETURN(map.shape, DecodeMeshBlob(mesh));
  COHORT_ASSIGN_OR_RETURN(const VariationSummary summary, DecodeSummaryBlob(bytes));
  for (const MetricValues& values : summary.values) {
    map.rms.push_back(values[static_cast<size_t>(Metric::kRms)]);
  }
  return map;
}

std::vector<double> ValuesAt(const VariationMap& map, const TriangleMesh& shape) {
  const Eigen::Vector3d center = map.shape.vertices.rowwise().mean();
  const PackedMesh queries = Packed(shape, center);
  const PackedMesh target = Packed(map.shape, center);
  PacketSearch search;
  NearestSlots nearest;
  search.Find(queries, target, nearest);
  std::vector<double> values(static_cast<size_t>(queries.VertexCount()));
  for (size_t slot = 0; slot < values.size(); ++slot) {
    const auto found = static_cast<size_t>(nearest.slots[slot]);
    values[static_cast<size_t>(queries.VertexOfSlot()[slot])] =
        map.rms[static_cast<size_t>(target.VertexOfSlot()[found])];
  }
  return values;
}

double RankCorrelation(std::span<const double> a, std::span<const double> b) {
  const std::vector<double> ranks_a = Ranks(a);
  const std::vector<double> ranks_b = Ranks(b);
  const double mean = static_cast<double>(a.size() - 1) / 2;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (size_t i = 0; i < ranks_a.size(); ++i) {
    ab += (ranks_a[i] - mean) * (ranks_b[i] - mean);
    aa += (ranks_a[i] - mean) * (ranks_a[i] - mean);
    bb += (ranks_b[i] - mean) * (ranks_b[i] - mean);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : std::numeric_limits<double>::quiet_NaN();
}

double TopTenthOverlap(std::span<const double> a, std::span<const double> b) {
  const size_t count = std::max<size_t>(1, a.size() / 10);
  const std::vector<size_t> order_a = SortedPositions(a);
  const std::vector<size_t> order_b = SortedPositions(b);
  const std::set<size_t> top(order_a.end() - static_cast<std::ptrdiff_t>(count), order_a.end());
  const auto both = std::count_if(order_b.end() - static_cast<std::ptrdiff_t>(count), order_b.end(),
                                  [&](size_t position) { return top.contains(position); });
  return static_cast<double>(both) / static_cast<double>(count);
}

}  // namespace cohort
