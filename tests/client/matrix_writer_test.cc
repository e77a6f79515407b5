#include "client/matrix_writer.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "client/files.h"
#include "common/base/random.h"
#include "common/base/thread_pool.h"
#include "common/report/csv.h"
#include "common/report/npy.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using testing::IsOk;
using testing::StatusIs;

class MatrixWriterTest : public ::testing::Test {
 protected:
  MatrixWriterTest()
      : folder_(fs::temp_directory_path() / ("matrix_writer_test-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~MatrixWriterTest() override { fs::remove_all(folder_); }
  fs::path folder_;
};

MetricMatrix RandomMatrix(int count) {
  Random random(5);
  MetricMatrix matrix;
  matrix.values.resize(count, count);
  for (int row = 0; row < count; ++row) {
    matrix.labels.push_back("mesh " + std::to_string(row));
    for (int column = 0; column < count; ++column) {
      matrix.values(row, column) = random.Uniform(0, 9);
    }
  }
  return matrix;
}

// 1,500 rows are written in two parts.
TEST_F(MatrixWriterTest, WritesTheBytesOfTheWholeTable) {
  ThreadPool threads(2);
  for (const int count : {0, 1, 3, 1500}) {
    const MetricMatrix matrix = RandomMatrix(count);
    ASSERT_THAT(WriteMatrixCsv(folder_ / "m.csv", matrix, "rms", threads), IsOk());
    ASSERT_THAT(WriteMatrixNpy(folder_ / "m.npy", matrix), IsOk());
    const auto csv = ReadWholeFile(folder_ / "m.csv");
    const auto npy = ReadWholeFile(folder_ / "m.npy");
    ASSERT_THAT(csv, IsOk());
    ASSERT_THAT(npy, IsOk());
    EXPECT_TRUE(*csv == MatrixCsv(matrix, "rms")) << count;
    EXPECT_TRUE(*npy == MatrixNpy(matrix.values)) << count;
  }
}

TEST_F(MatrixWriterTest, NamesTheFileThatCannotBeWritten) {
  SerialExecutor executor;
  const MetricMatrix matrix = RandomMatrix(2);
  EXPECT_THAT(WriteMatrixCsv(folder_ / "gone" / "m.csv", matrix, "rms", executor),
              StatusIs(absl::StatusCode::kNotFound, "gone/m.csv"));
  EXPECT_THAT(WriteMatrixNpy(folder_ / "gone" / "m.npy", matrix),
              StatusIs(absl::StatusCode::kNotFound, "gone/m.npy"));
}

}  // namespace
}  // namespace cohort
