#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/base/sha256.h"
#include "common/geometry/registration/procrustes.h"
#include "common/report/job_json.h"
#include "common/report/matrix_description.h"

namespace cohort {

/// A landmark set that went into a Procrustes analysis.
struct GpaSet {
  std::string name;       ///< Unique; the mesh that a table names, or the landmark file.
  std::string file;       ///< The file that it was read from.
  int64_t landmarks = 0;  ///< Read, whether common to all sets or not.
};

/// What a generalised Procrustes analysis was made from and gave.
struct GpaReport {
  std::vector<GpaSet> sets;  ///< N, in the order of the analysis.
  ProcrustesOptions options;
  ProcrustesAnalysis analysis;
  std::vector<std::string> left_out;  ///< Names that not every set has, bytewise order.
};

/// The Procrustes distances with the names of the sets.
[[nodiscard]] MetricMatrix GpaMatrix(const GpaReport& report);

/// Titles for its heat map. Kept sizes are in the unit of the files, taken for mm; normalised ones
/// have none.
[[nodiscard]] MatrixDescription DescribeGpa(const GpaReport& report);

/// "file,landmarks,centroid_size,distance_to_mean", a row per set: see ProcrustesAnalysis.
[[nodiscard]] std::string GpaSetsCsv(const GpaReport& report);

/// As JobJson without a job: software, method "gpa", parameters, what came out, inputs and files.
/// The same bytes for the same input.
struct GpaInput {
  std::string name;
  Digest sha256;
};
[[nodiscard]] std::string GpaJson(const GpaReport& report,
                                  std::span<const GpaInput> inputs,
                                  std::span<const ResultFile> files,
                                  const std::string& software_version);

[[nodiscard]] std::string_view ProcrustesSizeName(ProcrustesSize size);  ///< "kept", "normalized".
/// "exact", "fidentis".
[[nodiscard]] std::string_view ProcrustesVariantName(ProcrustesOptions::Variant variant);

}  // namespace cohort
