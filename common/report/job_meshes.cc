#include "common/report/job_meshes.h"

#include <map>

namespace cohort {

std::string_view MeshStatus(const JobMesh& mesh) {
  return mesh.rejection.empty() ? "ok" : "rejected";
}

std::vector<std::string> PersonsOf(std::span<const std::string> names,
                                   std::span<const JobMesh> meshes) {
  std::map<std::string_view, std::string_view> person_of;
  for (const JobMesh& mesh : meshes) {
    const auto label = mesh.mesh.labels.find(std::string(kPersonLabel));
    if (label != mesh.mesh.labels.end()) person_of[mesh.mesh.name] = label->second;
  }
  std::vector<std::string> persons;
  persons.reserve(names.size());
  for (const std::string& name : names) {
    const auto found = person_of.find(name);
    persons.emplace_back(found == person_of.end() ? std::string_view() : found->second);
  }
  return persons;
}

MetricMatrix WithoutRejected(const RowMajorMatrix& values, std::span<const JobMesh> meshes) {
  std::vector<Eigen::Index> kept;
  MetricMatrix matrix;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i].rejection.empty()) {
      kept.push_back(static_cast<Eigen::Index>(i));
      matrix.labels.push_back(meshes[i].mesh.name);
    }
  }
  matrix.values = values(kept, kept);
  return matrix;
}

}  // namespace cohort
