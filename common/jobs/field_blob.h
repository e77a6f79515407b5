#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/jobs/job_spec.h"

namespace cohort {

/// What is kept of the distances of one directed pair.
struct KeptField {
  int64_t values = 0;  ///< Distances measured: the source's vertices, less rejected pairs.
  std::string bytes;   ///< EncodeVectors, EncodeCompact or EncodeSketch of them; empty: no values.
  friend bool operator==(const KeptField&, const KeptField&) = default;
};
/// Fields of all directed pairs sources x targets. The distances of a pair are in the order of the
/// slots of the packed source mesh as it was measured (PackedMesh); with Arithmetic::kFidentis they
/// are signed and in the order of the file's vertices.
struct FieldBlock {
  std::vector<int32_t> sources;   ///< Job indices, rows.
  std::vector<int32_t> targets;   ///< Job indices, columns.
  std::vector<KeptField> fields;  ///< fields[row * targets.size() + column].
};
struct FieldBlob {
  Retention retention = Retention::kMetrics;
  std::vector<FieldBlock> blocks;
};
/// "COHFLDS1", uint64 retention, uint64 blocks, each { uint64 rows, uint64 columns, int32 sources,
/// int32 targets, per pair { int64 values, uint64 size, bytes } }.
[[nodiscard]] std::string EncodeFieldBlob(const FieldBlob& blob);
[[nodiscard]] absl::StatusOr<FieldBlob> DecodeFieldBlob(std::string_view bytes);

}  // namespace cohort
