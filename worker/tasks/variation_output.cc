#include "worker/tasks/variation_output.h"

#include <iterator>

#include "common/pairs/signature.h"

namespace cohort {

VariationOutput::VariationOutput(const Task& task, int64_t vertices)
    : wants_correspondences_(task.wants_correspondences),
      moves_reference_(task.moves_reference),
      signatures_{.meshes = {},
                  .fields = DisplacementFields(std::ssize(SignatureVertices(vertices)))},
      correspondences_{.meshes = {}, .fields = DisplacementFields(vertices)} {
  part_.distances.resize(vertices, std::ssize(task.meshes));
  sum_ = Eigen::Matrix3Xd::Zero(3, moves_reference_ ? vertices : 0);
}

void VariationOutput::Add(int32_t mesh, const Eigen::Matrix3Xd& displacement, Counters& counters) {
  part_.distances.col(std::ssize(part_.meshes)) =
      displacement.colwise().norm().transpose().cast<float>();
  if (moves_reference_) {
    sum_ += displacement;
  }
  ++part_.displacement.mesh_count;
  part_.meshes.push_back(mesh);
  signatures_.meshes.push_back(mesh);
  signatures_.fields.Add(SignatureOf(displacement));
  if (wants_correspondences_) {
    correspondences_.meshes.push_back(mesh);
    correspondences_.fields.Add(displacement.cast<float>());
  }
  counters.variation += {.index_builds = 1, .lookups = displacement.cols()};
}

VariationOutput::Blobs VariationOutput::Encode() && {
  part_.distances.conservativeResize(Eigen::NoChange, std::ssize(part_.meshes));
  part_.displacement.sum = sum_.cast<float>();
  return {.variation = EncodeVariationBlob(part_),
          .signatures = EncodeCorrespondenceBlob(signatures_),
          .correspondences =
              wants_correspondences_ ? EncodeCorrespondenceBlob(correspondences_) : std::string()};
}

}  // namespace cohort
