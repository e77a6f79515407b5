#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/job_frame.h"
#include "common/base/executor.h"
#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/pairs/measure_spec.h"

namespace cohort {

/// A mesh that is not in a job, in the job's frame.
struct Probe {
  std::string name;  ///< Of the file, without its folder.
  MeshHealth health;
  Alignment alignment;  ///< To the job's reference.
  FramedMesh framed;
};

/// Reads a mesh file, makes it canonical and aligns it to the reference of the job with the job's
/// options, as its own meshes were. A coarse pose is found by shape, also where the job used
/// landmarks. With method none it stays where it is.
/// @return as ReadWholeFile, MakeCanonical, FindCoarsePose and AlignByIcp, naming the file;
///         kFailedPrecondition as JobFrame::CheckHasFrame.
[[nodiscard]] absl::StatusOr<Probe> AlignProbe(const JobFrame& frame,
                                               const std::filesystem::path& file,
                                               const PairMeshOptions& options);

/// How near a mesh of a job is to a probe.
struct Match {
  int32_t mesh = 0;  ///< Job index.
  double value = 0;  ///< Both directions as one number.
  double from_probe = 0;
  double to_probe = 0;
};

/// Measures the probe against some active meshes of the job, exactly and both ways; nearest first,
/// ties by index, NaN last. The same bytes with any executor.
[[nodiscard]] absl::StatusOr<std::vector<Match>> RankMeshes(const JobFrame& frame,
                                                            const Probe& probe,
                                                            const std::vector<int32_t>& meshes,
                                                            const MeasureSpec& measure,
                                                            Symmetrization symmetrization,
                                                            Executor& executor);

}  // namespace cohort
