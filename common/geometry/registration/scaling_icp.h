#pragma once

#include <cstdint>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/nearest/correspondence.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// How ICP goes from one pose to the next.
enum class Acceleration {
  kNone,  ///< To the best fit to the nearest vertices: the textbook's step.
  /// Extrapolates the last steps, and takes the textbook's step where that is worse. Comes near the
  /// end with a sixteenth of the vertices first, unless all iterations are asked for (tolerance 0).
  kAnderson,
};

/// Pairs whose target vertex lies on the open boundary: the source reaches beyond the target there.
enum class BoundaryPairs { kKeep, kReject };

struct IcpOptions {
  ScaleMode scale_mode = ScaleMode::kSymmetric;
  /// Largest factor by which the scale may differ from the start's, either way, >= 1; 0: unbounded
  /// (but see kCollapse in AlignByIcp).
  double scale_limit = 0;
  /// With a scale: first the rigid motion until the mean distance changes by less than 2 %.
  bool rigid_first = true;
  int max_iterations = 200;  ///< >= 1.
  /// Stop when a pass changed the distance by no more than this (mesh units): with kNone the mean
  /// nearest-neighbour distance, as in the thesis; with kAnderson, whose steps jump, the RMS, which
  /// never rises. 0: never, all iterations run.
  double tolerance = 1e-6;
  Acceleration acceleration = Acceleration::kAnderson;
  double trimmed_share = 0;  ///< Share of the pairs, the farthest, that do not count: [0, 0.9].
  /// Pairs farther apart do not count (mesh units; with kSymmetric times the root of the scale).
  /// 0: all count.
  double distance_limit = 0;
  BoundaryPairs boundary_pairs = BoundaryPairs::kKeep;
  Correspondence correspondence = Correspondence::kVertex;
  [[nodiscard]] absl::Status Validate() const;
  friend bool operator==(const IcpOptions&, const IcpOptions&) = default;
};

/// Similarity and how well it converged.
struct Alignment {
  Similarity T_target_source;
  int iterations = 0;      ///< Passes over all vertices.
  bool converged = false;  ///< The stop rule held before max_iterations was reached.
  bool at_scale_limit = false;
  /// Of the last pass: source vertices, moved by T_target_source, to the vertices of the target
  /// that were nearest before that move, of the pairs that count. No extra look-up is spent on it.
  double rms_residual = 0;
  double mean_residual = 0;
  double overlap = 1;  ///< Share of the source's vertices over the target, not beyond its border;
                       ///< 1 with surface correspondences, which do not know.
  double kept_share = 1;  ///< Share of the pairs that count.
  int64_t lookups = 0;    ///< Nearest-vertex queries made, those of the coarse run included.
};

/// The squared error (mean over the pairs that count; for ScaleMode::kSymmetric divided by the
/// scale) at each pose that ICP went on from, the coarse run left out. Never rises, but for
/// rounding, as long as no boundary pairs are rejected.
using IcpTrace = std::vector<double>;

/// Scaling ICP: repeat { nearest vertex of each source vertex, closed-form similarity }.
///
/// Each pass fits the absolute similarity from the untransformed source, so that no drift builds
/// up. Neither half of a pass can raise the squared error (Besl, McKay 1992); for the symmetric
/// scale that holds for the error divided by the scale, which Horn's symmetric fit minimises. An
/// accelerated pose that raises it is dropped for the textbook's (Pavlov et al. 2018).
/// @param source  at least 3 vertices, source units.
/// @param T_target_source  the start.
/// @param trace  filled if not null.
/// @return kInvalidArgument for bad options or too few vertices; kFailedPrecondition if the fit is
///         impossible, fewer than 3 pairs count, or the scale leaves [0.1, 10] times the start
///         (collapse).
/// Source: Besl, McKay 1992; Horn 1987; thesis section 3.2; Walker, Ni 2011 (Anderson mixing);
///         Jost, Huegli 2003 (coarse to fine).
[[nodiscard]] absl::StatusOr<Alignment> AlignByIcp(const IcpMesh& source,
                                                   const IcpMesh& target,
                                                   const Similarity& T_target_source,
                                                   const IcpOptions& options,
                                                   PacketSearch& search,
                                                   IcpTrace* trace = nullptr);

}  // namespace cohort
