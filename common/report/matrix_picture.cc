#include "common/report/matrix_picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

namespace cohort {
namespace {

// Half of the range around a constant, relative to it; and the narrowest range ticks can be put on.
constexpr double kConstantSpread = 0.05;
constexpr double kNarrowest = 1e-9;

// First row (or column) of block `index` when `count` rows are cut into `blocks`.
Eigen::Index BlockBegin(Eigen::Index index, Eigen::Index count, Eigen::Index blocks) {
  return index * count / blocks;
}

double BlockMean(const Eigen::Ref<const RowMajorMatrix>& values, int side, int row, int column) {
  const Eigen::Index count = values.rows();
  const Eigen::Index row_end = BlockBegin(row + 1, count, side);
  const Eigen::Index column_end = BlockBegin(column + 1, count, side);
  double sum = 0;
  int64_t known = 0;
  for (Eigen::Index r = BlockBegin(row, count, side); r < row_end; ++r) {
    for (Eigen::Index c = BlockBegin(column, count, side); c < column_end; ++c) {
      const double value = values(r, c);
      if (r == c || std::isnan(value)) continue;
      sum += value;
      ++known;
    }
  }
  return known > 0 ? sum / static_cast<double>(known) : std::numeric_limits<double>::quiet_NaN();
}

void Survey(const Eigen::Ref<const RowMajorMatrix>& values, MatrixPicture& picture) {
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -smallest;
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    for (Eigen::Index column = 0; column < values.cols(); ++column) {
      if (row == column) continue;
      const double value = values(row, column);
      if (std::isnan(value)) {
        ++picture.missing;
        continue;
      }
      smallest = std::min(smallest, value);
      largest = std::max(largest, value);
    }
  }
  const bool is_empty = smallest > largest;
  picture.smallest = is_empty ? 0 : smallest;
  picture.largest = is_empty ? 0 : largest;
}

}  // namespace

ValueRange UsableRange(const ValueRange& range) {
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  if (magnitude == 0) return {0, 1};
  if (range.high - range.low > kNarrowest * magnitude) return range;
  const double middle = (range.low + range.high) / 2;
  return {middle - kConstantSpread * magnitude, middle + kConstantSpread * magnitude};
}

MatrixPicture MakeMatrixPicture(const Eigen::Ref<const RowMajorMatrix>& values, int max_side) {
  assert(values.rows() >= 1 && values.rows() == values.cols() && max_side >= 1);
  MatrixPicture picture;
  picture.side = static_cast<int>(std::min<Eigen::Index>(values.rows(), max_side));
  picture.shows_diagonal = picture.side == values.rows();
  picture.values.reserve(static_cast<size_t>(picture.side) * static_cast<size_t>(picture.side));
  for (int row = 0; row < picture.side; ++row) {
    for (int column = 0; column < picture.side; ++column) {
      picture.values.push_back(BlockMean(values, picture.side, row, column));
    }
  }
  Survey(values, picture);
  ValueRange range = QuantileRange(picture.values, 0, 1);
  if (const std::optional<double> fence = FarFence(picture.values)) {
    range.high = *fence;
    picture.clipped_high = true;
  }
  picture.range = UsableRange(range);
  return picture;
}

}  // namespace cohort
