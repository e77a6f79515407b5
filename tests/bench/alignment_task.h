#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/scaling_icp.h"
#include "tests/bench/bench.h"
#include "tests/bench/rivals/plain_icp.h"

namespace cohort {

/// Faces turned, shifted and scaled as scans come, and the template that they are aligned to.
struct AlignmentTask {
  std::unique_ptr<IcpMesh> target;
  std::unique_ptr<IcpRival> rival;        ///< The same target for nanoflann.
  std::vector<Eigen::Matrix3Xd> sources;  ///< Double, mm.
  std::vector<std::unique_ptr<IcpMesh>> packed;

  [[nodiscard]] PointList Source(size_t i) const { return {sources[i].data(), sources[i].cols()}; }
  /// Vertices of all sources.
  [[nodiscard]] double QueryCount() const;
};

/// Rotations up to 15 degrees, shifts up to 5 mm, scales around 1 by 2 %: after centring, as
/// make_faces poses its scans.
[[nodiscard]] absl::StatusOr<AlignmentTask> MakeAlignmentTask(Bench& bench, int vertices);

/// AlignByIcp from the centred start, to 1e-6 mm.
[[nodiscard]] absl::StatusOr<Alignment> AlignOurs(const IcpMesh& source,
                                                  const IcpMesh& target,
                                                  ScaleMode scale_mode,
                                                  PacketSearch& search);

/// Plain ICP on nanoflann from the same start with the same stop.
[[nodiscard]] PlainIcpResult AlignPlainly(const AlignmentTask& task,
                                          size_t source,
                                          ScaleMode scale_mode);

}  // namespace cohort
