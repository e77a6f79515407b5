#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Distance of two clusters from those of their members: mean, largest, smallest, or the growth of
/// the squared error (Ward; "ward.D2" of R's hclust, "ward" of scipy: heights in the metric's
/// unit).
enum class Linkage { kAverage, kComplete, kSingle, kWard };
[[nodiscard]] std::string_view LinkageName(Linkage linkage);  ///< "average", "complete", ...
[[nodiscard]] std::optional<Linkage> LinkageFromName(std::string_view name);

/// Two clusters become one. Numbers of clusters: 0..N-1 the meshes, N+i what merge i made; as in
/// scipy's linkage matrix. (R's hclust$merge has -(c+1) for c < N, else c-N+1.)
struct Merge {
  int64_t left = 0;   ///< The lower number of the two.
  int64_t right = 0;  ///< The higher one.
  double height = 0;  ///< Distance at which they merge, in the metric's unit.
  int64_t size = 0;   ///< Meshes in the new cluster.
};

struct Dendrogram {
  std::vector<Merge> merges;        ///< N-1, heights ascending (but for rounding).
  std::vector<int64_t> leaf_order;  ///< N meshes such that no branches cross: left before right.
};

/// More meshes take hours where the copy of their matrix (3.2 GB at this number) does not fit into
/// the machine's memory: their columns lie far apart.
inline constexpr int64_t kMostClustered = 20'000;

/// Agglomerative clustering of N >= 2 meshes, by the nearest-neighbour chain: O(N^2) time, and one
/// copy of the matrix (a LargeMatrix).
///
/// Ties: the chain begins at the lowest cluster and goes on to the nearest; of several, to where it
/// came from, else to the one with the lowest mesh. Merges of equal height stay in the order found.
/// @return as RequireDissimilarities and RequireComplete.
/// Source: Murtagh 1983; Lance, Williams 1967 (update); Murtagh, Legendre 2014 (Ward).
[[nodiscard]] absl::StatusOr<Dendrogram> ClusterMeshes(const MatrixView& distances,
                                                       Linkage linkage);

/// The tree in Newick form, one line with LF: "((a:1,b:1):0.5,c:1.5);". Branch lengths are height
/// differences such that two meshes are as far apart along the tree as the height of their merge:
/// half of it on each side. Labels in quotes where Newick needs them. R: ape::read.tree.
[[nodiscard]] std::string NewickText(const Dendrogram& dendrogram,
                                     std::span<const std::string> labels);

/// The cluster of each mesh when the last count-1 merges are undone; numbers from 0 in the order of
/// the first mesh of each. 1 <= count <= N.
[[nodiscard]] std::vector<int64_t> CutDendrogram(const Dendrogram& dendrogram, int64_t count);

}  // namespace cohort
