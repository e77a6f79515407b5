#include "client/matrix_writer.h"

#include <algorithm>
#include <string>
#include <vector>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/report/csv.h"
#include "common/report/npy.h"

namespace cohort {
namespace {

constexpr int64_t kValuesAtOnce = 2'000'000;  ///< About 40 MB of text.

}  // namespace

absl::Status WriteMatrixCsv(const std::filesystem::path& file,
                            const MatrixView& matrix,
                            std::string_view corner,
                            Executor& executor) {
  COHORT_ASSIGN_OR_RETURN(FileWriter out, FileWriter::Create(file));
  COHORT_RETURN_IF_ERROR(out.Append(MatrixCsvHeader(matrix, corner)));
  const int64_t rows = matrix.values.rows();
  const int64_t at_once = std::clamp<int64_t>(kValuesAtOnce / std::max<int64_t>(rows, 1), 1, 4096);
  for (int64_t begin = 0; begin < rows; begin += at_once) {
    std::vector<std::string> texts(static_cast<size_t>(std::min(at_once, rows - begin)));
    executor.ParallelFor(std::ssize(texts), [&](int64_t i) {
      texts[static_cast<size_t>(i)] = MatrixCsvRow(matrix, begin + i);
    });
    for (const std::string& text : texts) {
      COHORT_RETURN_IF_ERROR(out.Append(text));
    }
  }
  return out.Finish();
}

absl::Status WriteMatrixNpy(const std::filesystem::path& file, const MatrixView& matrix) {
  COHORT_ASSIGN_OR_RETURN(FileWriter out, FileWriter::Create(file));
  COHORT_RETURN_IF_ERROR(out.Append(NpyHeader(matrix.values.rows(), matrix.values.cols())));
  COHORT_RETURN_IF_ERROR(out.Append({reinterpret_cast<const char*>(matrix.values.data()),
                                     static_cast<size_t>(matrix.values.size()) * sizeof(double)}));
  return out.Finish();
}

}  // namespace cohort
