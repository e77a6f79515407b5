#pragma once

#include <filesystem>
#include <string_view>

#include <absl/status/status.h>

#include "common/analysis/metric_matrix.h"
#include "common/base/executor.h"

namespace cohort {

// Both write aside and rename, a part at a time: the file may be larger than memory.

/// The bytes of MatrixCsv (common/report/csv.h). @return as FileWriter.
[[nodiscard]] absl::Status WriteMatrixCsv(const std::filesystem::path& file,
                                          const MatrixView& matrix,
                                          std::string_view corner,
                                          Executor& executor);

/// The bytes of MatrixNpy (common/report/npy.h). @return as FileWriter.
[[nodiscard]] absl::Status WriteMatrixNpy(const std::filesystem::path& file,
                                          const MatrixView& matrix);

}  // namespace cohort
