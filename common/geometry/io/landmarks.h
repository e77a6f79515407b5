#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/mesh/landmark_set.h"

namespace cohort {

enum class LandmarkFormat { kCsv, kPickedPoints, kFcsv, kMarkupsJson };

/// Sizes beyond which a file is refused.
struct LandmarkLimits {
  int64_t max_bytes = int64_t{16} << 20;
  int64_t max_landmarks = 200'000;  ///< In the whole file.
  int64_t max_name_bytes = 256;
  /// @return kInvalidArgument if a limit is not positive.
  [[nodiscard]] absl::Status Validate() const;
};

/// The landmarks of one mesh.
struct MeshLandmarks {
  std::string mesh;  ///< File name of the mesh as the table has it; empty if the file names none.
  LandmarkSet landmarks;
};

/// Format by content, then by the extension of `file_name`.
/// @return kInvalidArgument if neither tells.
[[nodiscard]] absl::StatusOr<LandmarkFormat> DetectLandmarkFormat(std::string_view bytes,
                                                                  std::string_view file_name);

/// Reads a landmark file given as bytes (UTF-8).
///
/// - csv: a header row, then one row for each landmark. Columns, in any order: `name` (or
///   `landmark`, `label`), `x`, `y`, `z`, and `file` (or `mesh`) if the table speaks of several
///   meshes; other columns are passed over. Separator: comma, semicolon or tab, by the header.
///   A point whose three coordinates are empty, NA or NaN is missing.
/// - .pp (MeshLab PickedPoints): points with active="0" are missing.
/// - .fcsv (3D Slicer): the file must state its coordinate system, LPS (1) or RAS (0).
/// - .mrk.json (3D Slicer markups): control points of all its lists; only those whose
///   positionStatus is "defined" (or not given). No coordinateSystem means LPS, as Slicer's schema
///   has it.
/// Missing points are left out. Slicer writes meshes in LPS by default, so positions in RAS are
/// brought to LPS: x and y change sign. The others are taken as they are, in the frame and unit of
/// the mesh file.
/// @param file_name  for the format and for messages only; nothing is opened.
/// @return one entry for each mesh that the file names, in the order of their first rows; exactly
///         one, without a mesh name, if it names none. kInvalidArgument with file, line or field
///         and reason; kResourceExhausted if a limit is exceeded.
[[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> ReadLandmarkTable(
    std::string_view bytes, std::string_view file_name, const LandmarkLimits& limits = {});

/// ReadLandmarkTable for a file about one mesh.
/// @return kInvalidArgument also if it is a table of several meshes.
[[nodiscard]] absl::StatusOr<LandmarkSet> ReadLandmarks(std::string_view bytes,
                                                        std::string_view file_name,
                                                        const LandmarkLimits& limits = {});

/// csv with the columns name,x,y,z; numbers read back to the same doubles. RFC 4180: CRLF, quotes
/// where needed.
[[nodiscard]] std::string WriteLandmarksCsv(const LandmarkSet& landmarks);

/// csv with the columns file,landmark,x,y,z; see WriteLandmarksCsv.
[[nodiscard]] std::string WriteLandmarkTableCsv(std::span<const MeshLandmarks> meshes);

}  // namespace cohort
