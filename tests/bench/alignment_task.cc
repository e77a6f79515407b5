#include "tests/bench/alignment_task.h"

#include "common/base/status_macros.h"
#include "common/geometry/synthetic/capture.h"

namespace cohort {
namespace {

Similarity CenteredStart(const IcpMesh& source, const IcpMesh& target) {
  Similarity start;
  start.translation = target.Center() - source.Center();
  return start;
}

}  // namespace

double AlignmentTask::QueryCount() const {
  double count = 0;
  for (const Eigen::Matrix3Xd& source : sources) {
    count += static_cast<double>(source.cols());
  }
  return count;
}

absl::StatusOr<AlignmentTask> MakeAlignmentTask(Bench& bench, int vertices) {
  const int sources = bench.options.IsQuick() ? 3 : 9;
  const PoseOptions pose = {.max_rotation_degrees = 15, .max_translation = 5, .scale_sd = 0.02};
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(vertices, sources));
  COHORT_ASSIGN_OR_RETURN(const auto target, bench.template_face.Get(vertices, 1));
  AlignmentTask task;
  task.target = std::make_unique<IcpMesh>(target[0].mesh.vertices);
  task.rival = MakeIcpRival(target[0].Points());
  for (size_t i = 0; i < faces.size(); ++i) {
    task.sources.push_back(DrawPose(i, pose).T_file_canonical.Apply(faces[i].mesh.vertices));
    task.packed.push_back(std::make_unique<IcpMesh>(task.sources.back()));
  }
  return task;
}

absl::StatusOr<Alignment> AlignOurs(const IcpMesh& source,
                                    const IcpMesh& target,
                                    ScaleMode scale_mode,
                                    PacketSearch& search) {
  const IcpOptions options = {.scale_mode = scale_mode};
  return AlignByIcp(source, target, CenteredStart(source, target), options, search);
}

PlainIcpResult AlignPlainly(const AlignmentTask& task, size_t source, ScaleMode scale_mode) {
  return PlainIcp(task.Source(source), *task.rival,
                  CenteredStart(*task.packed[source], *task.target), scale_mode,
                  IcpOptions{}.tolerance);
}

}  // namespace cohort
