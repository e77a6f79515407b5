#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/base/executor.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/synthetic/capture.h"
#include "common/geometry/synthetic/face_parameters.h"

namespace cohort {

/// A synthetic cohort with known truth. Same options, same bytes: on any machine, with any number
/// of threads. A person has the same shape at any number of people, captures and vertices.
struct DemoOptions {
  int people = 4;           ///< 1..100,000.
  int captures = 2;         ///< Of each person, 1..26; the first is neutral.
  int64_t vertices = 5000;  ///< Of each mesh, exactly; 100..2,000,000.
  uint64_t seed = 1;
  double identity_spread = 1.0;      ///< How far people differ, 0..2; 1 is plausible.
  double expression_strength = 0.8;  ///< Of captures after the first, 0..1; 0 keeps all neutral.
  double noise = 0.05;               ///< White scanner noise, mm, 0..1.
  double warp = 0.12;                ///< Smooth scanner error, mm, 0..2.
  PoseOptions pose;

  /// @return kInvalidArgument with the name, the value and the range of the first field outside.
  [[nodiscard]] absl::Status Validate() const;
};

/// What is known of one scan without its mesh.
struct DemoCapture {
  std::string file;        ///< "person01_a.ply": the part before "_" is the person.
  std::string person;      ///< "person01".
  std::string capture;     ///< "a", "b", ...
  std::string expression;  ///< "neutral", "smile 0.42 + brow_raise 0.15".
  FaceParameters face;     ///< The true shape.
  CapturePose pose;
};

struct DemoScan {
  DemoCapture capture;
  TriangleMesh mesh;  ///< As in the file: posed, mm.
};

/// Describes scan (person, capture), both counted from 0. Cheap.
///
/// @return kInvalidArgument if the options are not valid, kOutOfRange if there is no such scan.
[[nodiscard]] absl::StatusOr<DemoCapture> DescribeDemoCapture(const DemoOptions& options,
                                                              int person,
                                                              int capture);

/// All scans of the cohort without meshes, person by person: what LabelsCsv and TruthCsv take.
[[nodiscard]] absl::StatusOr<std::vector<DemoCapture>> DescribeDemoCohort(
    const DemoOptions& options);

/// Makes scan (person, capture), both counted from 0; the same as in MakeDemoCohort.
///
/// @return as DescribeDemoCapture.
[[nodiscard]] absl::StatusOr<DemoScan> MakeDemoScan(const DemoOptions& options,
                                                    int person,
                                                    int capture);

/// Makes all scans, person by person. For cohorts that do not fit in memory: MakeDemoScan.
[[nodiscard]] absl::StatusOr<std::vector<DemoScan>> MakeDemoCohort(const DemoOptions& options,
                                                                   Executor& executor);

/// "file,person,capture,expression" and a line for each scan. RFC 4180 but lines end in LF.
[[nodiscard]] std::string LabelsCsv(std::span<const DemoCapture> captures);

/// "file,person,capture,scale,qw,qx,qy,qz,tx,ty,tz" and a line for each scan:
/// p_file = scale * R(q) * p_canonical + t, mm. Numbers read back to the same doubles.
[[nodiscard]] std::string TruthCsv(std::span<const DemoCapture> captures);

/// How different the true shapes are: RMS over corresponding points, mm, after the similarity that
/// fits the row's noise-free shape best to the column's.
///
/// N x N in the order given, zero diagonal; not symmetric, as the column's scale counts.
/// @return kInvalidArgument for more than 2,000 scans; what FitSimilarity returns.
[[nodiscard]] absl::StatusOr<Eigen::MatrixXd> TruthRms(std::span<const DemoCapture> captures,
                                                       Executor& executor);

/// The matrix of TruthRms as CSV: header "file,<file>,...", a row for each scan.
[[nodiscard]] std::string TruthRmsCsv(std::span<const DemoCapture> captures,
                                      const Eigen::Ref<const Eigen::MatrixXd>& rms);

}  // namespace cohort
