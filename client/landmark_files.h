#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/mesh/landmark_set.h"
#include "common/jobs/job_spec.h"
#include "common/jobs/landmark_blob.h"

namespace cohort {

/// Landmarks of one mesh as a file has them.
struct ReadLandmarkSet {
  std::string path;  ///< Of the landmark file, for messages.
  std::string file;  ///< Its name, without folders.
  std::string mesh;  ///< The mesh that a row of a table names; empty: the file is about one mesh.
  LandmarkSet landmarks;
};

/// The files themselves; a folder stands for all .csv, .pp, .fcsv and .mrk.json files in it, by
/// name.
/// @return kFailedPrecondition for a folder without such files; kUnknown if it cannot be read.
[[nodiscard]] absl::StatusOr<std::vector<std::filesystem::path>> ExpandLandmarkPaths(
    std::span<const std::string> paths);

/// Reads the landmark files that ExpandLandmarkPaths gives.
/// @return also as ReadWholeFile and ReadLandmarkTable, naming the file.
[[nodiscard]] absl::StatusOr<std::vector<ReadLandmarkSet>> ReadLandmarkFiles(
    std::span<const std::string> paths);

/// Joins landmarks and meshes. A row of a table belongs to the mesh of that name, with or without
/// extension; a file about one mesh to the mesh of the same stem ("anna.mrk.json" and
/// "anna_picked_points.pp" to "anna.ply"). Rows of tables about other meshes are passed over: a
/// table may speak of a whole study.
/// @return kInvalidArgument, naming up to three of each: meshes without landmarks, files about one
///         mesh that is not there; or a mesh with landmarks from two places, landmarks that could
///         belong to two meshes.
[[nodiscard]] absl::StatusOr<LandmarkTable> MatchLandmarks(std::span<const ReadLandmarkSet> sets,
                                                           std::span<const std::string> meshes);

/// Whether every mesh has three landmarks in common with the base mesh.
/// @param base  a mesh of the table; empty: not known yet, then three landmarks at all.
/// @return kInvalidArgument naming up to three meshes and the landmarks that they lack.
[[nodiscard]] absl::Status CheckCommonLandmarks(const LandmarkTable& table,
                                                const std::string& base);

/// The landmark blob of a job: reads `paths`, matches and checks them, and sets spec.landmarks.
/// @param meshes  names of the job's meshes, in its order.
/// @return as the functions above.
[[nodiscard]] absl::StatusOr<std::string> MakeLandmarkBlob(std::span<const std::string> paths,
                                                           std::span<const std::string> meshes,
                                                           JobSpec& spec);

}  // namespace cohort
