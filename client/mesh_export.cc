#include "client/mesh_export.h"

#include <map>
#include <set>

#include <absl/strings/str_cat.h>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/geometry/io/write_mesh.h"

namespace cohort {
namespace {

// A name that stays in its folder. Mesh names come from whoever filled the set.
std::string SafeName(const std::string& mesh) {
  std::string name = PrintableUtf8(mesh);
  for (char& c : name) {
    if (c == '/' || c == '\\') c = '_';
  }
  if (name.find_first_not_of('.') == std::string::npos) return absl::StrCat("_", name);
  return name;
}

std::string Encode(const TriangleMesh& mesh, MeshFormat format) {
  switch (format) {
    case MeshFormat::kPly:
      return WritePly(mesh);
    case MeshFormat::kObj:
      return WriteObj(mesh);
    case MeshFormat::kStl:
      return WriteStl(mesh);
  }
  return "";
}

absl::Status WithName(const std::string& mesh, const absl::Status& status) {
  if (status.ok()) return status;
  return {status.code(), mesh + ": " + std::string(status.message())};
}

}  // namespace

std::string_view MeshFormatName(MeshFormat format) {
  switch (format) {
    case MeshFormat::kPly:
      return "ply";
    case MeshFormat::kObj:
      return "obj";
    case MeshFormat::kStl:
      return "stl";
  }
  return "";
}

std::optional<MeshFormat> MeshFormatFromName(std::string_view name) {
  for (const MeshFormat format : {MeshFormat::kPly, MeshFormat::kObj, MeshFormat::kStl}) {
    if (MeshFormatName(format) == name) return format;
  }
  return std::nullopt;
}

std::vector<std::string> ExportNames(const std::vector<std::string>& meshes, MeshFormat format) {
  const std::string extension = absl::StrCat(".", std::string(MeshFormatName(format)));
  std::map<std::string, int> uses;
  std::vector<std::string> stems;
  for (const std::string& mesh : meshes) {
    const std::string name = SafeName(mesh);
    const size_t dot = name.rfind('.');
    stems.push_back(dot == std::string::npos || dot == 0 ? name : name.substr(0, dot));
    ++uses[stems.back()];
  }
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (size_t i = 0; i < meshes.size(); ++i) {
    std::string name = uses[stems[i]] == 1 ? stems[i] : SafeName(meshes[i]);
    while (!taken.insert(name).second) name += "_";
    names.push_back(name + extension);
  }
  return names;
}

absl::StatusOr<int64_t> WriteAlignedMeshes(Session& session,
                                           const FetchedJob& fetched,
                                           MeshFormat format,
                                           const std::filesystem::path& folder,
                                           Executor& executor) {
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  const std::vector<size_t> meshes = MeshesOfRows(fetched);
  const std::vector<Similarity> transforms = TransformsOf(fetched);
  const std::vector<std::string> names = ExportNames(fetched.matrix.Labels(), format);
  std::vector<absl::Status> written(meshes.size());
  executor.ParallelFor(std::ssize(meshes), [&](int64_t i) {
    const auto row = static_cast<size_t>(i);
    absl::StatusOr<TriangleMesh> mesh = FetchJobMesh(session, fetched, meshes[row]);
    if (!mesh.ok()) {
      written[row] = mesh.status();
      return;
    }
    mesh->vertices = transforms[meshes[row]].Apply(mesh->vertices);
    written[row] = WriteWholeFile(folder / names[row], Encode(*mesh, format));
  });
  for (size_t row = 0; row < meshes.size(); ++row) {
    COHORT_RETURN_IF_ERROR(WithName(fetched.matrix.Labels()[row], written[row]));
  }
  return std::ssize(meshes);
}

}  // namespace cohort
