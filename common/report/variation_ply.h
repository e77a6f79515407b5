#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/jobs/blobs.h"
#include "common/report/quantiles.h"

namespace cohort {

/// What the first and the last colour of VariationPly stand for: the 2nd and 98th percentile of the
/// RMS distances of all vertices, so that a few torn edges do not take all the colours.
[[nodiscard]] ValueRange VariationColorRange(const VariationSummary& summary);

/// The mean shape with, for each vertex, all metrics over the meshes as scalars (rms, mean,
/// geometric_mean, min, max, variance, p75) and the RMS distance as colour.
/// @return kInvalidArgument if the summary is of another number of vertices.
[[nodiscard]] absl::StatusOr<std::string> VariationPly(const TriangleMesh& mean_shape,
                                                       const VariationSummary& summary);

/// The same values as a legacy VTK file (binary PolyData, version 3.0) for ParaView and R.
/// @return as VariationPly.
[[nodiscard]] absl::StatusOr<std::string> VariationVtk(const TriangleMesh& mean_shape,
                                                       const VariationSummary& summary);

/// The mean shape alone.
[[nodiscard]] std::string MeanShapePly(const TriangleMesh& mean_shape);

}  // namespace cohort
