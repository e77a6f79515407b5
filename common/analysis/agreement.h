#pragma once

#include <cstdint>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// How the k nearest meshes of one mesh agree in two matrices.
struct RowAgreement {
  int64_t missed = 0;         ///< Of the reference's k, those that the other has not among its k.
  bool same_order = false;    ///< None missed, and each at the same rank.
  bool same_nearest = false;  ///< The first of both is the same mesh.
  bool nearest_kept = false;  ///< The reference's first is among the other's k.
};

/// The same over all meshes; for k = 3 the thesis's triads.
struct NeighbourAgreement {
  std::vector<RowAgreement> rows;
  int64_t correct = 0;          ///< Meshes with all k in the same order.
  int64_t wrong_order = 0;      ///< All k, in another order.
  std::vector<int64_t> missed;  ///< [m-1]: meshes with m of the k missed, m = 1..k.
  int64_t kept = 0;             ///< Neighbours of the reference that the other has too.
  int64_t wanted = 0;           ///< All of the reference (rows x k).
  int64_t same_nearest = 0;
  int64_t nearest_kept = 0;
};

/// Compares the k nearest of each mesh in `other` with those in `reference`; both as
/// NearestNeighbours gives them (ties to the lower column, missing values left out). A row of the
/// reference with under k values asks for as many as it has.
/// @param reference, other  same labels in the same order.
/// @return kInvalidArgument if the labels differ, k < 1, or k is not below the number of meshes.
/// Source: thesis tables 5.9-5.13.
[[nodiscard]] absl::StatusOr<NeighbourAgreement> CompareNeighbours(const MetricMatrix& reference,
                                                                   const MetricMatrix& other,
                                                                   int k);

/// Which of two matrices each cell is closer to in a third one.
enum class Closer : int8_t { kFirst, kSecond, kEqual, kMissing };

struct Closeness {
  /// N x N, row by row, the diagonal too (equal if all are zero there, as in the thesis).
  std::vector<Closer> cells;
  int64_t first = 0;
  int64_t second = 0;
  int64_t equal = 0;
  int64_t missing = 0;  ///< A value of the cell is NaN.
};

/// Counts cells by |first - reference| against |second - reference|.
/// @return kInvalidArgument if the labels differ.
/// Source: thesis figure 5.6.
[[nodiscard]] absl::StatusOr<Closeness> CompareCloseness(const MetricMatrix& first,
                                                         const MetricMatrix& second,
                                                         const MetricMatrix& reference);

}  // namespace cohort
