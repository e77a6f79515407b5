#include "common/geometry/comparison/corresponded_rms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/geometry/comparison/field_kernels.h"

namespace cohort {
namespace {

/// Rows of 16 of a mesh that are gone through at a time: a tile's stay in the first cache, those of
/// some hundred meshes in the second.
constexpr int64_t kRowsAtATime = 64;
/// Below this share of |u|^2 + |v|^2 a squared distance has lost too many digits.
constexpr double kLeastShare = 0.01;

int64_t RowsOf(const DisplacementFields& fields) {
  return fields.Stride() / kFieldLanes;
}

/// The fields of a tile's side from a row of 16 on; the last one again where there are fewer.
std::array<const float*, kFieldTile> SideAt(const DisplacementFields& fields,
                                            int64_t mesh,
                                            int64_t row) {
  std::array<const float*, kFieldTile> side{};
  for (int64_t k = 0; k < kFieldTile; ++k) {
    side[static_cast<size_t>(k)] =
        fields.Data(std::min(mesh + k, fields.MeshCount() - 1)) + row * kFieldLanes;
  }
  return side;
}

/// kFieldTile rows from `row` on with as many columns from `column` on.
struct Tile {
  int64_t row = 0;
  int64_t column = 0;
  std::array<double, kFieldTileLanes> lanes{};

  [[nodiscard]] double Product(int64_t i, int64_t j) const {
    const double* const begin = lanes.data() + (i * kFieldTile + j) * kFieldLanes;
    return std::accumulate(begin, begin + kFieldLanes, 0.0);
  }
};

/// Fills the tiles a few rows of 16 at a time, so that these stay in the caches for all tiles.
void Multiply(const DisplacementFields& rows,
              const DisplacementFields& columns,
              std::vector<Tile>& tiles) {
  const FieldKernels& kernels = BestFieldKernels();
  for (int64_t first = 0; first < RowsOf(rows); first += kRowsAtATime) {
    const int64_t count = std::min(kRowsAtATime, RowsOf(rows) - first);
    for (Tile& tile : tiles) {
      kernels.add_products(SideAt(rows, tile.row, first).data(),
                           SideAt(columns, tile.column, first).data(), count, tile.lanes.data());
    }
  }
}

/// All products; of fields with themselves those above the diagonal and on it.
Eigen::MatrixXd Multiply(const DisplacementFields& rows, const DisplacementFields& columns) {
  std::vector<Tile> tiles;
  for (int64_t row = 0; row < rows.MeshCount(); row += kFieldTile) {
    for (int64_t column = &rows == &columns ? row : 0; column < columns.MeshCount();
         column += kFieldTile) {
      tiles.push_back({.row = row, .column = column});
    }
  }
  Multiply(rows, columns, tiles);
  Eigen::MatrixXd products(rows.MeshCount(), columns.MeshCount());
  for (const Tile& tile : tiles) {
    for (int64_t i = 0; i < std::min<int64_t>(kFieldTile, products.rows() - tile.row); ++i) {
      for (int64_t j = 0; j < std::min<int64_t>(kFieldTile, products.cols() - tile.column); ++j) {
        products(tile.row + i, tile.column + j) = tile.Product(i, j);
      }
    }
  }
  return products;
}

/// |u|^2 of each field, with the roundings of the products.
Eigen::VectorXd SquaredNorms(const DisplacementFields& fields) {
  std::vector<Tile> tiles;
  for (int64_t mesh = 0; mesh < fields.MeshCount(); mesh += kFieldTile) {
    tiles.push_back({.row = mesh, .column = mesh});
  }
  Multiply(fields, fields, tiles);
  Eigen::VectorXd norms(fields.MeshCount());
  for (int64_t mesh = 0; mesh < fields.MeshCount(); ++mesh) {
    const int64_t k = mesh % kFieldTile;
    norms(mesh) = tiles[static_cast<size_t>(mesh / kFieldTile)].Product(k, k);
  }
  return norms;
}

double SquaredDifference(const DisplacementFields& rows,
                         int64_t row,
                         const DisplacementFields& columns,
                         int64_t column) {
  return (rows.Of(row).cast<double>() - columns.Of(column).cast<double>()).squaredNorm();
}

}  // namespace

DisplacementFields::DisplacementFields(int64_t vertices)
    : vertices_(vertices), stride_((3 * vertices + kFieldLanes - 1) / kFieldLanes * kFieldLanes) {}

void DisplacementFields::Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacements) {
  AlignedArray<float>& values = values_.emplace_back(static_cast<size_t>(stride_));
  Eigen::Map<Eigen::Matrix3Xf>(values.data(), 3, vertices_) = displacements;
  std::fill(values.data() + 3 * vertices_, values.data() + stride_, 0.0F);
}

Eigen::Map<const Eigen::Matrix3Xf> DisplacementFields::Of(int64_t mesh) const {
  return {Data(mesh), 3, vertices_};
}

Eigen::MatrixXd CorrespondedRms(const DisplacementFields& rows, const DisplacementFields& columns) {
  const bool is_symmetric = &rows == &columns;
  const Eigen::MatrixXd products = Multiply(rows, columns);
  const Eigen::VectorXd row_norms =
      is_symmetric ? Eigen::VectorXd(products.diagonal()) : SquaredNorms(rows);
  const Eigen::VectorXd column_norms = is_symmetric ? row_norms : SquaredNorms(columns);
  Eigen::MatrixXd rms(products.rows(), products.cols());
  for (int64_t row = 0; row < rms.rows(); ++row) {
    for (int64_t column = is_symmetric ? row : 0; column < rms.cols(); ++column) {
      const double norms = row_norms(row) + column_norms(column);
      double squared = norms - 2 * products(row, column);
      if (squared < kLeastShare * norms) {
        squared = SquaredDifference(rows, row, columns, column);
      }
      rms(row, column) = std::sqrt(squared / static_cast<double>(rows.VertexCount()));
    }
  }
  if (is_symmetric) {
    rms.triangularView<Eigen::StrictlyLower>() = rms.transpose();
  }
  return rms;
}

}  // namespace cohort
