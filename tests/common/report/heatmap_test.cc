#include "common/report/heatmap.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "common/report/canvas.h"
#include "common/report/heatmap_layout.h"
#include "common/report/matrix_picture.h"
#include "tests/common/report/png_pixels.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::Contains;
using testing::DecodePng;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Pixels;
using ::testing::StartsWith;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// |row - column| off the diagonal, so every value is known.
MetricMatrix Differences(int count) {
  MetricMatrix matrix;
  matrix.values.resize(count, count);
  for (int row = 0; row < count; ++row) {
    matrix.labels.push_back(std::string(1, 'm').append(std::to_string(row)));
    for (int column = 0; column < count; ++column) {
      matrix.values(row, column) = std::abs(row - column);
    }
  }
  return matrix;
}

// A pixel near the corner of a cell, where no number is drawn.
Rgb CornerOfCell(const Pixels& pixels, const HeatmapLayout& layout, int row, int column) {
  const double x = layout.matrix.x + column * layout.cell;
  const double y = layout.matrix.y + row * layout.cell;
  return pixels.At(static_cast<int>(x * Canvas::kPixelsPerPoint) + 3,
                   static_cast<int>(y * Canvas::kPixelsPerPoint) + 3);
}

TEST(MatrixPicture, OfAFewMeshesHasTheEntriesWithoutTheDiagonal) {
  const MatrixPicture picture = MakeMatrixPicture(Differences(3).values, 10);
  EXPECT_EQ(picture.side, 3);
  EXPECT_TRUE(picture.shows_diagonal);
  EXPECT_EQ(picture.At(0, 2), 2);
  EXPECT_TRUE(std::isnan(picture.At(1, 1)));
  EXPECT_EQ(picture.range.low, 1);
  EXPECT_EQ(picture.range.high, 2);
  EXPECT_FALSE(picture.clipped_high);
}

TEST(MatrixPicture, OfManyMeshesHasMeansOfBlocks) {
  RowMajorMatrix values(4, 4);
  values << 0, 1, 2, 4,  //
      3, 0, 6, 8,        //
      1, 1, 0, 9,        //
      1, kNaN, 7, 0;
  const MatrixPicture picture = MakeMatrixPicture(values, 2);
  EXPECT_FALSE(picture.shows_diagonal);
  // The diagonal and the missing entry do not count.
  EXPECT_THAT(picture.values, ElementsAre(2, 5, 1, 8));
  EXPECT_EQ(picture.missing, 1);
  EXPECT_EQ(picture.smallest, 1);
  EXPECT_EQ(picture.largest, 9);
}

TEST(MatrixPicture, CoversEveryEntryWhenBlocksAreUneven) {
  RowMajorMatrix values = RowMajorMatrix::Constant(7, 7, 2.0);
  values(6, 0) = 2 + 4;
  const MatrixPicture picture = MakeMatrixPicture(values, 3);  // Blocks of 2, 2 and 3.
  EXPECT_DOUBLE_EQ(picture.At(2, 0), 2 + 4.0 / 6);
  EXPECT_EQ(picture.At(0, 2), 2);
}

TEST(MatrixPicture, EndsItsColoursBeforeAFailedMesh) {
  RowMajorMatrix values(20, 20);
  for (int i = 0; i < 400; ++i) values(i / 20, i % 20) = 1 + (i * 7 % 11) / 10.0;
  values.row(5).setConstant(500);
  const MatrixPicture picture = MakeMatrixPicture(values, 100);
  EXPECT_TRUE(picture.clipped_high);
  EXPECT_LT(picture.range.high, 10);
  EXPECT_EQ(picture.largest, 500);
}

TEST(MatrixPicture, HasAUsableRangeForAConstant) {
  const MatrixPicture picture = MakeMatrixPicture(RowMajorMatrix::Constant(3, 3, 2.0), 10);
  EXPECT_LT(picture.range.low, 2);
  EXPECT_GT(picture.range.high, 2);
  const MatrixPicture empty = MakeMatrixPicture(RowMajorMatrix::Constant(3, 3, kNaN), 10);
  EXPECT_EQ(empty.missing, 6);
  EXPECT_LT(empty.range.low, empty.range.high);
}

TEST(HeatmapLayout, StatesMetricCountMethodAndUnit) {
  MatrixDescription description;
  description.metric = Metric::kVariance;
  description.method = Method::kOne;
  description.symmetrization = Symmetrization::kDirected;
  const HeatmapLayout layout = LayOutHeatmap(Differences(4), description);
  EXPECT_EQ(layout.title, std::string(MetricTitle(Metric::kVariance)) + ", 4 meshes");
  EXPECT_THAT(layout.subtitle, HasSubstr("method one"));
  EXPECT_THAT(layout.subtitle, HasSubstr("row = source, column = target"));
  EXPECT_EQ(layout.bar_title, "mm²");
  EXPECT_EQ(layout.row_title, "source");
  EXPECT_EQ(layout.column_title, "target");
  EXPECT_THAT(layout.notes, IsEmpty());
}

TEST(HeatmapLayout, NamesFewMeshesAndNumbersMany) {
  const HeatmapLayout few = LayOutHeatmap(Differences(100), {});
  ASSERT_EQ(few.marks.size(), 100U);
  EXPECT_EQ(few.marks[99].text, "m99");
  const HeatmapLayout many = LayOutHeatmap(Differences(250), {});
  ASSERT_LE(many.marks.size(), 14U);
  EXPECT_EQ(many.marks.front().text, "1");
  EXPECT_EQ(many.marks[1].text, "50");
  EXPECT_DOUBLE_EQ(many.marks[1].offset, 49.5 * many.cell);
}

TEST(HeatmapLayout, KeepsEverythingOnThePage) {
  for (const int count : {1, 2, 8, 60, 300}) {
    const HeatmapLayout layout = LayOutHeatmap(Differences(count), {});
    EXPECT_GE(layout.matrix.x, TextWidth(layout.marks.back().text, layout.mark_style)) << count;
    EXPECT_GT(layout.width, layout.bar.x + layout.bar.width) << count;
    EXPECT_GT(layout.height, layout.matrix.y + layout.matrix.height) << count;
    EXPECT_GT(layout.width, TextWidth(layout.subtitle, {11.5})) << count;
  }
}

TEST(HeatmapLayout, IsNoLargerForThousandsOfMeshes) {
  const HeatmapLayout layout = LayOutHeatmap(Differences(1760), {});
  EXPECT_EQ(layout.picture.side, 1600);
  EXPECT_EQ(layout.matrix.width, 800);
  EXPECT_THAT(layout.notes, ElementsAre(StartsWith("Each pixel is the mean of about 1.1 x 1.1")));
}

TEST(HeatmapLayout, ShortensLongNames) {
  MetricMatrix matrix = Differences(3);
  for (std::string& label : matrix.labels) label.insert(0, 300, 'x');
  const HeatmapLayout layout = LayOutHeatmap(matrix, {});
  EXPECT_EQ(layout.marks[1].text, "…1");
  EXPECT_LT(layout.width, 800);
}

TEST(HeatmapPng, PaintsCellsDiagonalAndMissingValues) {
  MetricMatrix matrix = Differences(3);
  matrix.values(1, 0) = kNaN;
  const absl::StatusOr<std::string> png = HeatmapPng(matrix, {});
  ASSERT_THAT(png, testing::IsOk());
  ASSERT_THAT(*png, StartsWith("\x89PNG\r\n\x1a\n"));
  const Pixels pixels = DecodePng(*png);
  const HeatmapLayout layout = LayOutHeatmap(matrix, {});
  EXPECT_EQ(pixels.width, static_cast<int>(layout.width) * Canvas::kPixelsPerPoint);
  EXPECT_EQ(pixels.height, static_cast<int>(layout.height) * Canvas::kPixelsPerPoint);
  EXPECT_EQ(CornerOfCell(pixels, layout, 0, 2), MapColor(1));
  EXPECT_EQ(CornerOfCell(pixels, layout, 0, 1), MapColor(0));
  EXPECT_EQ(CornerOfCell(pixels, layout, 1, 0), kNoValueColor);
  EXPECT_EQ(CornerOfCell(pixels, layout, 1, 1), CornerOfCell(pixels, layout, 2, 2));
  EXPECT_EQ(pixels.At(0, 0), kWhite);
}

TEST(HeatmapPng, PaintsEveryCellOfALargeMatrix) {
  const MetricMatrix matrix = Differences(500);
  const Pixels pixels = DecodePng(*HeatmapPng(matrix, {}));
  const HeatmapLayout layout = LayOutHeatmap(matrix, {});
  ASSERT_EQ(layout.cell, 1.5);  // Three pixels.
  const auto middle = [&](int row, int column) {
    return pixels.At(static_cast<int>(layout.matrix.x * 2) + column * 3 + 1,
                     static_cast<int>(layout.matrix.y * 2) + row * 3 + 1);
  };
  const auto color = [&](int difference) {
    return MapColor(layout.picture.range.Position(difference));
  };
  EXPECT_EQ(middle(10, 400), color(390));
  EXPECT_EQ(middle(400, 10), color(390));
  EXPECT_EQ(middle(250, 251), color(1));
  EXPECT_EQ(middle(498, 1), color(497));
}

TEST(HeatmapPng, IsTheSameEveryTimeAndHoldsNoTimeStamp) {
  const absl::StatusOr<std::string> first = HeatmapPng(Differences(12), {});
  const absl::StatusOr<std::string> second = HeatmapPng(Differences(12), {});
  ASSERT_THAT(first, testing::IsOk());
  EXPECT_EQ(*first, *second);
  for (const char* chunk : {"tIME", "tEXt", "iTXt", "zTXt", "eXIf"}) {
    EXPECT_THAT(testing::PngChunks(*first), ::testing::Not(Contains(chunk)));
  }
}

TEST(HeatmapPng, DrawsAnyFileName) {
  MetricMatrix matrix = Differences(4);
  matrix.labels = {"\xff\xfe.ply", "a\tb", "", "漢字"};
  EXPECT_THAT(HeatmapPng(matrix, {}), testing::IsOk());
}

TEST(HeatmapPng, DrawsConstantEmptyAndSingleMatrices) {
  MetricMatrix matrix = Differences(3);
  matrix.values.setZero();
  EXPECT_THAT(HeatmapPng(matrix, {}), testing::IsOk());
  matrix.values.setConstant(kNaN);
  EXPECT_THAT(HeatmapPng(matrix, {}), testing::IsOk());
  matrix.values.setConstant(1e-300);
  EXPECT_THAT(HeatmapPng(matrix, {}), testing::IsOk());
  EXPECT_THAT(HeatmapPng(Differences(1), {}), testing::IsOk());
}

TEST(HeatmapPng, RefusesSizesThatDisagree) {
  EXPECT_THAT(HeatmapPng({}, {}), StatusIs(absl::StatusCode::kInvalidArgument, "0 labels"));
  MetricMatrix matrix = Differences(3);
  matrix.labels.pop_back();
  EXPECT_THAT(HeatmapPng(matrix, {}), StatusIs(absl::StatusCode::kInvalidArgument, "3 x 3"));
}

}  // namespace
}  // namespace cohort
