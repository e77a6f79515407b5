#include "common/report/npy.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>

namespace cohort {
namespace {

using ::testing::EndsWith;

TEST(MatrixNpy, IsByteForByteTheFormat) {
  RowMajorMatrix values(2, 2);
  values << 1, 2, -0.5, 0;
  const std::string npy = MatrixNpy(values);
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }";
  header.resize(117, ' ');  // 10 bytes before, a line break after: 128.
  const std::string expected_start = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + '\n';
  const std::string one("\x00\x00\x00\x00\x00\x00\xf0\x3f", 8);
  const std::string two("\x00\x00\x00\x00\x00\x00\x00\x40", 8);
  const std::string minus_half("\x00\x00\x00\x00\x00\x00\xe0\xbf", 8);
  EXPECT_EQ(npy, expected_start + one + two + minus_half + std::string(8, '\0'));
}

TEST(MatrixNpy, StartsItsDataAtAMultipleOf64Bytes) {
  const RowMajorMatrix values = RowMajorMatrix::Zero(1000, 1000);
  const std::string npy = MatrixNpy(values);
  EXPECT_EQ((npy.size() - 8000000) % 64, 0U);
}

TEST(MatrixNpy, KeepsTheBitsOfEveryNumber) {
  RowMajorMatrix values(2, 2);
  values << std::numeric_limits<double>::denorm_min(), 1.0 / 3, -1e300,
      std::numeric_limits<double>::quiet_NaN();
  const std::string npy = MatrixNpy(values);
  const std::string bits(reinterpret_cast<const char*>(values.data()), 32);
  EXPECT_THAT(npy, EndsWith(bits));
}

TEST(MatrixNpy, OfNoMeshesIsAHeader) {
  const std::string npy = MatrixNpy(RowMajorMatrix(0, 0));
  EXPECT_EQ(npy.size(), 128U);
  EXPECT_THAT(npy, EndsWith(" \n"));
}

TEST(LabelsText, HasOneLinePerLabel) {
  const std::vector<std::string> labels = {"a.ply", "b c.ply", "č.ply"};
  EXPECT_EQ(LabelsText(labels), "a.ply\nb c.ply\nč.ply\n");
}

TEST(LabelsText, KeepsTheLineCountWhateverALabelHolds) {
  const std::vector<std::string> labels = {"a\nb", "c\r\nd"};
  EXPECT_EQ(LabelsText(labels), "a b\nc  d\n");
}

}  // namespace
}  // namespace cohort
