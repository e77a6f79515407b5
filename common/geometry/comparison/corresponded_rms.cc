#include "common/geometry/comparison/corresponded_rms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/geometry/comparison/field_kernels.h"

namespace cohort {
namespace {

/// Numbers of a mesh that are gone through at a time, in rows of 16: those of 16 meshes stay in the
/// second cache.
constexpr int64_t kRowsAtATime = 512;
constexpr int64_t kMeshesAtATime = 16;

int64_t RowsOf(const DisplacementFields& fields) {
  return fields.Stride() / kFieldLanes;
}

/// Sums of squared differences of one row and up to four columns.
struct Strip {
  int64_t row = 0;
  int64_t column = 0;
  std::array<double, kFieldStrip * kFieldLanes> lanes{};
};

/// The columns from `column` on; the last one again where there are fewer than four.
std::array<const float*, kFieldStrip> ColumnsAt(const DisplacementFields& columns, int64_t column) {
  std::array<const float*, kFieldStrip> chosen{};
  for (int64_t k = 0; k < kFieldStrip; ++k) {
    chosen[static_cast<size_t>(k)] = columns.Data(std::min(column + k, columns.MeshCount() - 1));
  }
  return chosen;
}

/// Strips of a block of at most kMeshesAtATime rows and columns.
std::vector<Strip> StripsOf(int64_t first_row,
                            int64_t rows,
                            int64_t first_column,
                            int64_t columns) {
  std::vector<Strip> strips;
  strips.reserve(kMeshesAtATime * kMeshesAtATime / kFieldStrip);
  for (int64_t row = first_row; row < std::min(first_row + kMeshesAtATime, rows); ++row) {
    for (int64_t column = first_column; column < std::min(first_column + kMeshesAtATime, columns);
         column += kFieldStrip) {
      strips.push_back({.row = row, .column = column});
    }
  }
  return strips;
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
  const FieldKernels& kernels = BestFieldKernels();
  Eigen::MatrixXd rms(rows.MeshCount(), columns.MeshCount());
  const auto finish = [&](const Strip& strip) {
    for (int64_t k = 0; k < std::min<int64_t>(kFieldStrip, rms.cols() - strip.column); ++k) {
      double sum = 0;
      for (int64_t lane = 0; lane < kFieldLanes; ++lane) {
        sum += strip.lanes[static_cast<size_t>(k * kFieldLanes + lane)];
      }
      rms(strip.row, strip.column + k) = std::sqrt(sum / static_cast<double>(rows.VertexCount()));
    }
  };
  for (int64_t row = 0; row < rms.rows(); row += kMeshesAtATime) {
    for (int64_t column = 0; column < rms.cols(); column += kMeshesAtATime) {
      std::vector<Strip> strips = StripsOf(row, rms.rows(), column, rms.cols());
      for (int64_t at = 0; at < RowsOf(rows); at += kRowsAtATime) {
        const int64_t count = std::min(kRowsAtATime, RowsOf(rows) - at);
        for (Strip& strip : strips) {
          std::array<const float*, kFieldStrip> others = ColumnsAt(columns, strip.column);
          for (const float*& other : others) {
            other += at * kFieldLanes;
          }
          kernels.add_squared_differences(rows.Data(strip.row) + at * kFieldLanes, others.data(),
                                          count, strip.lanes.data());
        }
      }
      std::for_each(strips.begin(), strips.end(), finish);
    }
  }
  return rms;
}

}  // namespace cohort
