#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

/// The predecessor's own results (../shared/golden) and how to read them.
namespace cohort::testing {

inline constexpr std::array<std::string_view, 8> kGoldenNames = {
    "face01a", "face01b", "face02a", "face02b", "face03a", "face03b", "face04a", "face04b"};
inline constexpr int kGoldenCount = 8;

/// ../shared/golden; empty if this checkout stands alone.
inline std::filesystem::path GoldenFolder() {
  const std::filesystem::path folder = COHORT_SOURCE_DIR "/../shared/golden";
  return std::filesystem::exists(folder / "README.md") ? folder : std::filesystem::path();
}

inline std::string ReadWhole(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  EXPECT_TRUE(stream.good()) << file;
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline TriangleMesh ReadGoldenMesh(const std::filesystem::path& file) {
  absl::StatusOr<TriangleMesh> mesh = ReadMesh(ReadWhole(file), file.filename().string());
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return mesh.ok() ? *std::move(mesh) : TriangleMesh();
}

/// As Java writes and reads floats.
inline float ParseFloat(std::string_view word) {
  float value = std::numeric_limits<float>::quiet_NaN();
  if (word != "NaN") {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    EXPECT_TRUE(error == std::errc() && end == word.data() + word.size()) << word;
  }
  return value;
}

/// The vn lines of an OBJ file in their order, 3 x n. Our reader passes over them.
inline Eigen::Matrix3Xf ReadNormals(const std::filesystem::path& file) {
  std::istringstream lines(ReadWhole(file));
  std::vector<float> values;
  for (std::string keyword, rest; lines >> keyword; std::getline(lines, rest)) {
    for (int axis = 0; keyword == "vn" && axis < 3; ++axis) {
      std::string word;
      lines >> word;
      values.push_back(ParseFloat(word));
    }
  }
  return Eigen::Map<Eigen::Matrix3Xf>(values.data(), 3,
                                      static_cast<Eigen::Index>(values.size() / 3));
}

/// The words of a CSV file, line by line.
inline std::vector<std::vector<std::string>> ReadTable(const std::filesystem::path& file) {
  std::istringstream lines(ReadWhole(file));
  std::vector<std::vector<std::string>> table;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::vector<std::string>& row = table.emplace_back();
    for (std::string word; std::getline(words, word, ',');) {
      row.push_back(word);
    }
  }
  return table;
}

/// A matrix of a METRIC_*.csv: rows compared, columns main.
inline Eigen::MatrixXf ReadMatrix(const std::filesystem::path& file) {
  Eigen::MatrixXf matrix(kGoldenCount, kGoldenCount);
  const std::vector<std::vector<std::string>> table = ReadTable(file);
  EXPECT_EQ(table.size(), kGoldenNames.size()) << file;
  for (Eigen::Index row = 0; row < kGoldenCount; ++row) {
    for (Eigen::Index column = 0; column < kGoldenCount; ++column) {
      matrix(row, column) =
          ParseFloat(table.at(static_cast<size_t>(row)).at(static_cast<size_t>(column)));
    }
  }
  return matrix;
}

// The README's, for float32 with the same order of sums.
inline constexpr float kGoldenRmsTolerance = 7e-6F;
inline constexpr float kGoldenMetricTolerance = 5e-5F;

inline constexpr std::array<std::string_view, kFidentisMetricCount> kGoldenMetrics = {
    "rms", "mean", "geometric_mean", "min", "max", "variance", "percentile75"};

/// The seven matrices, signed and absolute: rows compared, columns main.
class GoldenMatrices {
 public:
  void Set(Eigen::Index compared, Eigen::Index main, std::span<const float> signed_distances) {
    SetOne(signed_, compared, main, signed_distances);
    SetOne(absolute_, compared, main, FidentisAbsolute(signed_distances));
  }
  /// Compares with the METRIC_*.csv of `folder`, NaN with NaN.
  void ExpectNear(const std::filesystem::path& folder, float rms_tolerance, float tolerance) const {
    for (size_t metric = 0; metric < kGoldenMetrics.size(); ++metric) {
      const std::string name(kGoldenMetrics[metric]);
      const float allowed = metric == 0 ? rms_tolerance : tolerance;
      ExpectOne(folder, name + "_absolute", absolute_[metric], allowed);
      ExpectOne(folder, name + "_signed", signed_[metric], allowed);
    }
  }

 private:
  using Seven = std::vector<Eigen::MatrixXf>;
  static Seven Zeros() {
    return Seven(kGoldenMetrics.size(), Eigen::MatrixXf::Zero(kGoldenCount, kGoldenCount));
  }
  static void SetOne(Seven& matrices,
                     Eigen::Index compared,
                     Eigen::Index main,
                     std::span<const float> distances) {
    const FidentisMetricValues values = ComputeFidentisMetrics(distances);
    for (size_t metric = 0; metric < values.size(); ++metric) {
      matrices[metric](compared, main) = values[metric];
    }
  }
  static void ExpectOne(const std::filesystem::path& folder,
                        const std::string& name,
                        const Eigen::MatrixXf& ours,
                        float tolerance) {
    ExpectClose(ReadMatrix(folder / (name + ".csv")), ours, name, tolerance);
    ExpectClose(ReadMatrix(folder / (name + "_symmetric.csv")), FidentisSymmetric(ours),
                name + "_symmetric", tolerance);
  }
  static void ExpectClose(const Eigen::MatrixXf& golden,
                          const Eigen::MatrixXf& ours,
                          const std::string& name,
                          float tolerance) {
    float worst = 0;
    for (Eigen::Index i = 0; i < golden.size(); ++i) {
      const float expected = golden.data()[i];
      const float value = ours.data()[i];
      EXPECT_EQ(std::isnan(expected), std::isnan(value)) << name << " " << i;
      worst = std::isnan(expected) ? worst : std::max(worst, std::abs(expected - value));
    }
    EXPECT_LE(worst, tolerance) << name;
  }

  Seven absolute_ = Zeros();
  Seven signed_ = Zeros();
};

}  // namespace cohort::testing
