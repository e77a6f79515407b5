#pragma once

#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"
#include "common/base/executor.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/jobs/blobs.h"
#include "common/jobs/job_state.h"
#include "common/report/matrix_description.h"

namespace cohort {

/// What a report is made from. Nothing in it says when or where the job ran, so that the same work
/// gives the same report.
struct ReportInput {
  const Job& job;
  std::span<const JobMesh> meshes;  ///< The job's order, rejected ones too.
  std::span<const MeshAlignment> alignments;
  MatrixView matrix;                                   ///< Of the meshes that were not rejected.
  MatrixDescription description;                       ///< What its values are.
  std::span<const std::string> persons;                ///< One per row, "" for unknown.
  std::span<const std::vector<Neighbour>> neighbours;  ///< One list per row; none: left out.
  const TriangleMesh& mean_shape;
  const TriangleMesh& variation_shape;
  const VariationSummary& variation;
  std::span<const std::string> thumbnails;  ///< PNG, one per row, "" for none; or none at all.
  std::string thumbnails_note;              ///< Why there are none or some are missing.
  std::span<const std::string> notes;       ///< What people must know of the results.
  std::string software_version;             ///< "cohort 0.1.0".
};

/// report.html: one file that needs nothing else, no network, no font and no script of others; its
/// policy forbids the page to ask for any. Foreign text (file names, labels, reasons) is escaped.
///
/// Summary and parameters, health of the files with the flagged ones first, heat map, neighbours
/// with thumbnails, dendrogram, principal coordinates by label, distribution of the pairs,
/// identification and verification where persons are known, mean shape and variation, registration.
/// What cannot be made of this job (a cell without a value, too few or too many meshes) is named in
/// its place.
/// @param executor  for the pictures.
/// @return kInvalidArgument if sizes disagree; kInternal if a picture cannot be drawn.
[[nodiscard]] absl::StatusOr<std::string> ReportHtml(const ReportInput& input, Executor& executor);

}  // namespace cohort
