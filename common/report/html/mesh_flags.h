#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/report/html/report_html.h"

namespace cohort {

/// What is to be looked at in a mesh, one line each.
struct MeshFlags {
  std::vector<std::string> file;          ///< Warnings of the check at ingest.
  std::vector<std::string> registration;  ///< Of its alignment.
  std::vector<std::string> distances;     ///< Of its distances to the others.
  [[nodiscard]] bool Any() const {
    return !file.empty() || !registration.empty() || !distances.empty();
  }
};

/// The alignment of each mesh of the job, null where it has none.
[[nodiscard]] std::vector<const MeshAlignment*> AlignmentOfEach(const ReportInput& input);

/// One per mesh of the job. A residual or a mean distance far above all others (FarFence) is
/// flagged; not having converged only where that is the exception, not the rule of the options.
[[nodiscard]] std::vector<MeshFlags> FindFlags(const ReportInput& input);

}  // namespace cohort
