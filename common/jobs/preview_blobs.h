#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/comparison/corresponded_rms.h"

namespace cohort {

// What the preview matrix is made from and of; as the blobs in blobs.h.

/// Displacements from the vertices of the last reference to some aligned meshes, rounded.
struct CorrespondencePart {
  std::vector<int32_t> meshes;  ///< Job indices.
  DisplacementFields fields;    ///< One per mesh.
};
/// "COHCORR2", uint64 n, uint64 meshes, int32 indices, for each mesh: int32 step exponent, 3 n
/// int16 in steps. Also read: "COHCORR1", with 3 n float32 for each mesh, not yet rounded to steps.
[[nodiscard]] std::string EncodeCorrespondenceBlob(const CorrespondencePart& part);
[[nodiscard]] absl::StatusOr<CorrespondencePart> DecodeCorrespondenceBlob(std::string_view bytes);

/// Corresponded RMS of rows x columns, undirected.
struct PreviewBlock {
  std::vector<int32_t> rows;     ///< Job indices.
  std::vector<int32_t> columns;  ///< Job indices.
  std::vector<double> values;    ///< values[row * columns.size() + column], mesh units.
};
/// "COHPREV1", uint64 rows, uint64 columns, int32 rows, int32 columns, float64 values.
[[nodiscard]] std::string EncodePreviewBlob(const PreviewBlock& block);
[[nodiscard]] absl::StatusOr<PreviewBlock> DecodePreviewBlob(std::string_view bytes);

}  // namespace cohort
