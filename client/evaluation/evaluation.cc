#include "client/evaluation/evaluation.h"

#include <map>
#include <string>

#include "common/report/job_meshes.h"

namespace cohort {

Identities Evaluation::IdentitiesOf(const MetricMatrix& matrix) const {
  // Folders of other densities may have files of another format, hence of other names.
  std::map<std::string, std::string> persons;
  for (const Density& density : densities) {
    for (const MeshFile& file : density.files) {
      const auto found = file.mesh.labels.find(std::string(kPersonLabel));
      persons[file.mesh.name] = found == file.mesh.labels.end() ? "" : found->second;
    }
  }
  Identities identities;
  for (const std::string& label : matrix.labels) {
    identities.persons.push_back(persons[label]);
  }
  return identities;
}

}  // namespace cohort
