#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/labels_csv.h"
#include "common/analysis/metric_matrix.h"
#include "common/geometry/comparison/metrics.h"

namespace cohort {

/// Where a matrix comes from, and how it is to be taken.
struct AnalysisSource {
  std::string source;                  ///< Results folder, matrix file, or id of a job on a server.
  std::string server;                  ///< Address; asked if `source` is no file.
  std::optional<Metric> metric;        ///< Empty: that of the job.
  std::optional<PairRule> symmetrize;  ///< For matrices with two values a pair; empty: see below.
};

/// A matrix with what is known about its meshes.
struct AnalysisInput {
  std::string source;                       ///< As the user wrote it, for messages.
  MetricMatrix matrix;                      ///< Undirected; rejected meshes are not in it.
  std::string metric;                       ///< "rms"; empty: not known.
  std::string unit;                         ///< "mm"; empty: not known.
  Labels labels;                            ///< By mesh; those of the job.
  std::map<std::string, double> residuals;  ///< RMS of the alignment by mesh, mm; as far as known.
  std::vector<std::string> rejected;        ///< Meshes of the job that have no row.
  std::vector<std::string> notes;           ///< One line each.
};

/// Reads a matrix: of a results folder (matrix.npy + labels.txt, else matrix.csv; job.json
/// or remeasure.json, and meshes.csv if they are there), a file (ReadMatrixFile), or a finished job
/// of a server.
///
/// Undirected are the values of a job's own rule; those of a directed job are combined by
/// `symmetrize`, else by their mean, which a note says. A file that is not symmetric is refused
/// without `symmetrize`.
/// @return kNotFound if there is no such file, folder or job; kFailedPrecondition for signed
///         distances, another metric than the folder's, a job that has not finished;
///         kInvalidArgument with the file and what is wrong in it.
[[nodiscard]] absl::StatusOr<AnalysisInput> ReadAnalysisInput(const AnalysisSource& source);

}  // namespace cohort
