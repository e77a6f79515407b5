#include "common/jobs/action_key.h"

#include <bit>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "common/base/sha256.h"

namespace cohort {
namespace {

/// Text that two tasks share only if all that was added to it is the same.
class KeyText {
 public:
  /// Any bytes: names of files need not be UTF-8.
  KeyText& Add(std::string_view bytes) {
    absl::StrAppend(&text_, bytes.size(), ":");
    text_ += bytes;
    return *this;
  }
  KeyText& Add(int64_t number) {
    absl::StrAppend(&text_, number, ";");
    return *this;
  }
  KeyText& Add(const Digest& blob) { return Add(std::string_view(blob.Hex())); }
  KeyText& Add(const std::vector<Digest>& blobs) {
    Add(std::ssize(blobs));
    for (const Digest& blob : blobs) {
      Add(blob);
    }
    return *this;
  }
  KeyText& Add(const std::vector<TaskMesh>& meshes) {
    Add(std::ssize(meshes));
    for (const TaskMesh& mesh : meshes) {
      Add(mesh.index).Add(std::string_view(mesh.name)).Add(mesh.blob);
    }
    return *this;
  }
  [[nodiscard]] std::string Hash() const { return Sha256::Of(text_).Hex(); }

 private:
  std::string text_;
};

bool HaveSameOptions(const JobSpec& spec, const Task& task) {
  return spec.icp == task.icp && spec.undersampling == task.undersampling &&
         spec.compare == task.compare && spec.position_bits == task.position_bits &&
         spec.arithmetic == task.arithmetic;
}

}  // namespace

ActionKeys::ActionKeys() : options_text_(ToJson(options_).dump()) {}

std::string ActionKeys::Of(const Task& task) {
  if (!HaveSameOptions(options_, task)) {
    options_.icp = task.icp;
    options_.undersampling = task.undersampling;
    options_.compare = task.compare;
    options_.position_bits = task.position_bits;
    options_.arithmetic = task.arithmetic;
    // A spec carries the options: whatever is added to them is in its text.
    options_text_ = ToJson(options_).dump();
  }
  KeyText text;
  text.Add(kResultsVersion)
      .Add(TaskKindName(task.kind))
      .Add(task.meshes)
      .Add(task.targets)
      .Add(task.reference)
      .Add(task.alignments)
      .Add(task.partials)
      .Add(task.landmarks)
      .Add(std::string_view(options_text_));
  for (const bool flag :
       {task.wants_placed, task.wants_pose, task.wants_displacement, task.wants_variation,
        task.wants_correspondences, task.counts_reference_index, task.moves_reference}) {
    text.Add(flag ? 1 : 0);
  }
  for (const double coordinate : task.frame_center) {
    text.Add(std::bit_cast<int64_t>(coordinate));
  }
  if (!task.starts.empty()) {  // Else the text is that of builds which knew no starts.
    text.Add(std::string_view(task.starts));
  }
  return text.Hash();
}

}  // namespace cohort
