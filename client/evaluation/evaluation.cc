#include "client/evaluation/evaluation.h"

#include <algorithm>

#include "common/report/job_meshes.h"

namespace cohort {

Identities Evaluation::IdentitiesOf(const MetricMatrix& matrix) const {
  Identities identities;
  const std::vector<MeshFile>& files = densities.front().files;
  for (const std::string& label : matrix.labels) {
    const auto file = std::find_if(files.begin(), files.end(), [&](const MeshFile& candidate) {
      return candidate.mesh.name == label;
    });
    std::string person;
    if (file != files.end()) {
      const auto found = file->mesh.labels.find(std::string(kPersonLabel));
      person = found == file->mesh.labels.end() ? "" : found->second;
    }
    identities.persons.push_back(person);
  }
  return identities;
}

}  // namespace cohort
