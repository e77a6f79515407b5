#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/fetched_job.h"
#include "client/session.h"
#include "common/base/executor.h"
#include "common/geometry/io/read_mesh.h"

namespace cohort {

/// Subfolder of the results folder.
inline constexpr std::string_view kAlignedFolder = "aligned";

[[nodiscard]] std::string_view MeshFormatName(MeshFormat format);  ///< "ply", "obj", "stl".
[[nodiscard]] std::optional<MeshFormat> MeshFormatFromName(std::string_view name);

/// File names for meshes, one each: the mesh's with its extension exchanged, or, where two would
/// then be called the same, behind its own ("a.obj" and "a.ply" as PLY: a.obj.ply and a.ply.ply).
/// What could lead out of the folder (a slash, a name of dots) or is not printable becomes "_".
[[nodiscard]] std::vector<std::string> ExportNames(const std::vector<std::string>& meshes,
                                                   MeshFormat format);

/// Writes every mesh that was not rejected, where the job's alignment puts it, into `folder`, made
/// if new; other files in it stay.
/// @return how many; as FetchJobMesh and WriteWholeFile, naming the mesh.
[[nodiscard]] absl::StatusOr<int64_t> WriteAlignedMeshes(Session& session,
                                                         const FetchedJob& fetched,
                                                         MeshFormat format,
                                                         const std::filesystem::path& folder,
                                                         Executor& executor);

}  // namespace cohort
