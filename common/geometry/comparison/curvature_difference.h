#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cohort {

/// |K_c - K_p| of each query vertex p and its nearest vertex c: a field that is measured like one
/// of absolute distances, in the unit of the curvature (1 / mesh unit^2 for the Gaussian one, which
/// is what the predecessor compares as "Nearest Neighbor Curvature").
/// @param source_curvatures  n, one per query vertex.
/// @param target_curvatures  m, one per vertex of the target.
/// @param nearest  n indices below m.
/// Source: reference a5.
[[nodiscard]] std::vector<float> CurvatureDifferences(std::span<const double> source_curvatures,
                                                      std::span<const double> target_curvatures,
                                                      std::span<const int32_t> nearest);

}  // namespace cohort
