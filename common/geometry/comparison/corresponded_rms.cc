#include "common/geometry/comparison/corresponded_rms.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <numeric>

#include "common/geometry/comparison/product_kernels.h"

namespace cohort {
namespace {

/// Rows of values of a mesh that are gone through at a time: a tile's stay in the first cache,
/// those of some hundred meshes in the second.
constexpr int64_t kRowsAtATime = 64;

/// 2^exponent of the steps: with the least, 1 / step is a float; the most holds the largest float.
constexpr int32_t kLeastStepExponent = -100;
constexpr int32_t kMostStepExponent = 116;
/// |value| / step from here on would be rounded to more than kLargestFactor.
constexpr double kTooManySteps = kLargestFactor + 0.5;

int64_t RowsOf(const DisplacementFields& fields) {
  return fields.Stride() / kProductRow;
}

/// The least step that is large enough for coordinates of this magnitude.
int32_t StepExponentFor(float largest) {
  int exponent = 0;
  (void)std::frexp(largest, &exponent);  // largest < 2^exponent
  exponent -= std::bit_width(static_cast<uint32_t>(kLargestFactor));
  if (std::ldexp(static_cast<double>(largest), -exponent) >= kTooManySteps) {
    ++exponent;
  }
  return std::max(exponent, kLeastStepExponent);
}

/// The fields of a tile's side from a row of values on; the last one again where there are fewer.
std::array<const int16_t*, kProductTile> SideAt(const DisplacementFields& fields,
                                                int64_t mesh,
                                                int64_t row) {
  std::array<const int16_t*, kProductTile> side{};
  for (int64_t k = 0; k < kProductTile; ++k) {
    side[static_cast<size_t>(k)] =
        fields.Values(std::min(mesh + k, fields.MeshCount() - 1)).data() + row * kProductRow;
  }
  return side;
}

/// kProductTile rows from `row` on with as many columns from `column` on.
struct Tile {
  int64_t row = 0;
  int64_t column = 0;
  std::array<int64_t, kProductTileLanes> lanes{};

  /// Below 2^53, hence exact in double, up to 40 million vertices.
  [[nodiscard]] double Product(int64_t i, int64_t j) const {
    const int64_t* const begin = lanes.data() + (i * kProductTile + j) * kProductLanes;
    return static_cast<double>(std::accumulate(begin, begin + kProductLanes, int64_t{0}));
  }
};

/// Fills the tiles some rows of values at a time, so that these stay in the caches for all tiles.
void Multiply(const DisplacementFields& rows,
              const DisplacementFields& columns,
              std::vector<Tile>& tiles) {
  const ProductKernels& kernels = BestProductKernels();
  for (int64_t first = 0; first < RowsOf(rows); first += kRowsAtATime) {
    const int64_t count = std::min(kRowsAtATime, RowsOf(rows) - first);
    for (Tile& tile : tiles) {
      kernels.add_products(SideAt(rows, tile.row, first).data(),
                           SideAt(columns, tile.column, first).data(), count, tile.lanes.data());
    }
  }
}

/// u v of all rows and columns; of fields with themselves those above the diagonal and on it.
Eigen::MatrixXd Multiply(const DisplacementFields& rows, const DisplacementFields& columns) {
  std::vector<Tile> tiles;
  for (int64_t row = 0; row < rows.MeshCount(); row += kProductTile) {
    for (int64_t column = &rows == &columns ? row : 0; column < columns.MeshCount();
         column += kProductTile) {
      tiles.push_back({.row = row, .column = column});
    }
  }
  Multiply(rows, columns, tiles);
  Eigen::MatrixXd products(rows.MeshCount(), columns.MeshCount());
  for (const Tile& tile : tiles) {
    for (int64_t i = 0; i < std::min<int64_t>(kProductTile, products.rows() - tile.row); ++i) {
      for (int64_t j = 0; j < std::min<int64_t>(kProductTile, products.cols() - tile.column); ++j) {
        products(tile.row + i, tile.column + j) =
            tile.Product(i, j) * rows.Step(tile.row + i) * columns.Step(tile.column + j);
      }
    }
  }
  return products;
}

/// |u|^2 of each field.
Eigen::VectorXd SquaredNorms(const DisplacementFields& fields) {
  std::vector<Tile> tiles;
  for (int64_t mesh = 0; mesh < fields.MeshCount(); mesh += kProductTile) {
    tiles.push_back({.row = mesh, .column = mesh});
  }
  Multiply(fields, fields, tiles);
  Eigen::VectorXd norms(fields.MeshCount());
  for (int64_t mesh = 0; mesh < fields.MeshCount(); ++mesh) {
    const int64_t k = mesh % kProductTile;
    norms(mesh) = tiles[static_cast<size_t>(mesh / kProductTile)].Product(k, k) *
                  fields.Step(mesh) * fields.Step(mesh);
  }
  return norms;
}

}  // namespace

DisplacementFields::DisplacementFields(int64_t vertices)
    : vertices_(vertices), stride_((3 * vertices + kProductRow - 1) / kProductRow * kProductRow) {}

DisplacementFields::Field& DisplacementFields::AddField(int32_t step_exponent) {
  Field& field = fields_.emplace_back();
  field.step_exponent = step_exponent;
  field.values.Reset(static_cast<size_t>(stride_));
  std::fill(field.values.data() + 3 * vertices_, field.values.data() + stride_, int16_t{0});
  return field;
}

void DisplacementFields::Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacements) {
  assert(displacements.cols() == vertices_ && displacements.outerStride() == 3);
  const ProductKernels& kernels = BestProductKernels();
  const int64_t whole_rows = displacements.size() / kProductRow;
  const int64_t whole = whole_rows * kProductRow;
  std::array<float, kProductRow> rest{};
  std::copy(displacements.data() + whole, displacements.data() + displacements.size(),
            rest.begin());
  const auto largest = std::bit_cast<float>(
      std::max(kernels.largest(displacements.data(), whole_rows), kernels.largest(rest.data(), 1)));
  assert(std::isfinite(largest));
  Field& field = AddField(StepExponentFor(largest));
  const auto factor = static_cast<float>(std::ldexp(1.0, -field.step_exponent));
  kernels.quantize(displacements.data(), whole_rows, factor, field.values.data());
  if (whole < stride_) {
    kernels.quantize(rest.data(), 1, factor, field.values.data() + whole);
  }
}

bool DisplacementFields::MayAdd(int32_t step_exponent, std::span<const int16_t> values) {
  return step_exponent >= kLeastStepExponent && step_exponent <= kMostStepExponent &&
         std::all_of(values.begin(), values.end(), [](int16_t value) {
           return -kLargestFactor <= value && value <= kLargestFactor;
         });
}

void DisplacementFields::AddSteps(int32_t step_exponent, std::span<const int16_t> values) {
  assert(static_cast<int64_t>(values.size()) == 3 * vertices_ && MayAdd(step_exponent, values));
  std::copy(values.begin(), values.end(), AddField(step_exponent).values.data());
}

double DisplacementFields::Step(int64_t mesh) const {
  return std::ldexp(1.0, StepExponent(mesh));
}

std::span<const int16_t> DisplacementFields::Values(int64_t mesh) const {
  return {FieldOf(mesh).values.data(), static_cast<size_t>(3 * vertices_)};
}

Eigen::Matrix3Xd DisplacementFields::Of(int64_t mesh) const {
  using Steps = Eigen::Matrix<int16_t, 3, Eigen::Dynamic>;
  const Eigen::Map<const Steps> steps(FieldOf(mesh).values.data(), 3, vertices_);
  return steps.cast<double>() * Step(mesh);
}

Eigen::MatrixXd CorrespondedRms(const DisplacementFields& rows, const DisplacementFields& columns) {
  const bool is_symmetric = &rows == &columns;
  const Eigen::MatrixXd products = Multiply(rows, columns);
  const Eigen::VectorXd row_norms =
      is_symmetric ? Eigen::VectorXd(products.diagonal()) : SquaredNorms(rows);
  const Eigen::VectorXd column_norms = is_symmetric ? row_norms : SquaredNorms(columns);
  const auto vertices = static_cast<double>(rows.VertexCount());
  Eigen::MatrixXd rms(products.rows(), products.cols());
  for (int64_t row = 0; row < rms.rows(); ++row) {
    for (int64_t column = is_symmetric ? row : 0; column < rms.cols(); ++column) {
      // All three are whole multiples of the smaller step squared: with steps alike nothing is
      // rounded, and with others a little where the sum is large.
      const double squared = row_norms(row) + column_norms(column) - 2 * products(row, column);
      rms(row, column) = std::sqrt(std::max(squared, 0.0) / vertices);
    }
  }
  if (is_symmetric) {
    rms.triangularView<Eigen::StrictlyLower>() = rms.transpose();
  }
  return rms;
}

}  // namespace cohort
