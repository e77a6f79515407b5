#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/comparison/distance_sketch.h"

namespace cohort {

/// How distance fields are kept (retention `vectors`, `compact`, `sketch`). Signed fields too. A
/// field belongs to a mesh, so the decoders are told how many values there must be; they allocate
/// nothing before the sizes agree, and their kDataLoss names what is wrong.
/// Formats: four letters that name format and version, then (vectors, compact) one zstd frame with
/// a checksum. Source: reference performance.md 5.

/// Lossless: float32 bit by bit, byte planes, zstd; about 3.1 bytes a value. n >= 1.
[[nodiscard]] std::string EncodeVectors(std::span<const float> distances);
/// @return kDataLoss if the bytes are no field of `count` values.
[[nodiscard]] absl::StatusOr<std::vector<float>> DecodeVectors(std::string_view bytes,
                                                               int64_t count);

struct CompactOptions {
  /// Mesh units; 1 um for millimetres. See CompactStep.
  double step = 0.001;
  /// @return kInvalidArgument unless 2^-100 <= step <= 2^40.
  [[nodiscard]] absl::Status Validate() const;
};

/// The power of ten that is to meshes of this size (diagonal of the bounding box, mesh units, > 0)
/// what 1 um is to a head: 0.001 from 100 to 1000. For scans in metres it is 1e-6.
[[nodiscard]] double CompactStep(double diagonal);

/// The field rounded to whole steps: these or the differences of neighbours, whichever vary less,
/// in byte planes, zstd; 1.3 to 1.6 bytes a value for faces in mm, least in the order of a packed
/// mesh.
///
/// Nothing saturates: a field with |d| > 4194303 steps (4.19 m) is kept in steps twice as wide, or
/// four times, ..., and says so. Error of a kept value <= step / 2 + |d| 2^-24, the second part
/// from the rounding to float32. Zero stays zero; the sign stays.
/// @return kInvalidArgument for the options, an empty field, or a value that is not finite or not
///         below 2^100.
[[nodiscard]] absl::StatusOr<std::string> EncodeCompact(std::span<const float> distances,
                                                        const CompactOptions& options);

struct CompactField {
  std::vector<float> distances;
  double step = 0;  ///< The one used, mesh units.
};
/// @return kDataLoss if the bytes are no field of `count` values.
[[nodiscard]] absl::StatusOr<CompactField> DecodeCompact(std::string_view bytes, int64_t count);

/// What DecodeCompact will give for what EncodeCompact makes of these: metrics are computed from
/// the values as kept. Rounding twice changes nothing.
/// @return as EncodeCompact.
[[nodiscard]] absl::StatusOr<CompactField> RoundCompact(std::span<const float> distances,
                                                        const CompactOptions& options);

/// About 0.5 KB.
[[nodiscard]] std::string EncodeSketch(const DistanceSketch& sketch);
/// @return kDataLoss if the bytes are no sketch, or one whose parts contradict each other.
[[nodiscard]] absl::StatusOr<DistanceSketch> DecodeSketch(std::string_view bytes);

}  // namespace cohort
