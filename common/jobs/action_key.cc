#include "common/jobs/action_key.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "common/base/sha256.h"
#include "common/jobs/job_spec.h"

namespace cohort {
namespace {

nlohmann::json ToJson(const std::vector<TaskMesh>& meshes) {
  nlohmann::json list = nlohmann::json::array();
  for (const TaskMesh& mesh : meshes) {
    list.push_back({mesh.index, mesh.name, mesh.blob.Hex()});
  }
  return list;
}

nlohmann::json ToJson(const std::vector<Digest>& blobs) {
  nlohmann::json list = nlohmann::json::array();
  for (const Digest& blob : blobs) {
    list.push_back(blob.Hex());
  }
  return list;
}

}  // namespace

std::string ActionKey(const Task& task) {
  // A spec carries the options: whatever is added to them is in its text.
  JobSpec options;
  options.icp = task.icp;
  options.undersampling = task.undersampling;
  options.compare = task.compare;
  options.position_bits = task.position_bits;
  options.arithmetic = task.arithmetic;
  const nlohmann::json text = {{"results_version", kResultsVersion},
                               {"kind", TaskKindName(task.kind)},
                               {"meshes", ToJson(task.meshes)},
                               {"targets", ToJson(task.targets)},
                               {"reference", task.reference.Hex()},
                               {"alignments", ToJson(task.alignments)},
                               {"partials", ToJson(task.partials)},
                               {"landmarks", task.landmarks.Hex()},
                               {"options", ToJson(options)},
                               {"wants_placed", task.wants_placed},
                               {"wants_pose", task.wants_pose},
                               {"wants_displacement", task.wants_displacement},
                               {"wants_variation", task.wants_variation},
                               {"wants_correspondences", task.wants_correspondences},
                               {"counts_reference_index", task.counts_reference_index},
                               {"moves_reference", task.moves_reference},
                               {"frame_center", task.frame_center}};
  // Names of files need not be UTF-8.
  return Sha256::Of(text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).Hex();
}

}  // namespace cohort
