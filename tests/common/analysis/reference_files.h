#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/analysis/metric_matrix.h"
#include "common/base/random.h"

namespace cohort {

/// What tests/tools/reference_statistics.py wrote.
inline std::ifstream OpenReference(const std::string& name) {
  std::ifstream file(COHORT_SOURCE_DIR "/tests/common/analysis/reference/" + name);
  EXPECT_TRUE(file.is_open()) << name;
  return file;
}

inline std::vector<std::string> SplitAtCommas(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    fields.push_back(field);
  }
  return fields;
}

/// @param which  "a", "b" or "c".
inline MetricMatrix ReferenceMatrix(const std::string& which) {
  std::ifstream file = OpenReference("distances_" + which + ".csv");
  std::string line;
  std::getline(file, line);
  MetricMatrix matrix;
  matrix.labels = SplitAtCommas(line);
  matrix.labels.erase(matrix.labels.begin());
  const auto count = static_cast<Eigen::Index>(matrix.labels.size());
  matrix.values.resize(count, count);
  for (Eigen::Index row = 0; row < count; ++row) {
    std::getline(file, line);
    const std::vector<std::string> fields = SplitAtCommas(line);
    for (Eigen::Index column = 0; column < count; ++column) {
      matrix.values(row, column) = std::stod(fields.at(static_cast<size_t>(column + 1)));
    }
  }
  return matrix;
}

/// @param column  1: person, 2: group.
inline std::vector<std::string> ReferenceLabels(size_t column) {
  std::ifstream file = OpenReference("labels.csv");
  std::string line;
  std::getline(file, line);
  std::vector<std::string> labels;
  while (std::getline(file, line)) {
    labels.push_back(SplitAtCommas(line).at(column));
  }
  return labels;
}

/// Lines of "name number number ...".
class ReferenceValues {
 public:
  /// @param name  "scipy.txt" or "r.txt".
  explicit ReferenceValues(const std::string& name) {
    std::ifstream file = OpenReference(name);
    for (std::string line; std::getline(file, line);) {
      std::istringstream stream(line);
      std::string key;
      stream >> key;
      for (double value = 0; stream >> value;) {
        values_[key].push_back(value);
      }
    }
  }
  [[nodiscard]] std::vector<double> operator[](const std::string& name) const {
    return values_.at(name);
  }

 private:
  std::map<std::string, std::vector<double>> values_;
};

/// Distances of random points in `dimensions` dimensions, labels m0, m1, ...
inline MetricMatrix RandomDistances(Eigen::Index count, Eigen::Index dimensions, uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd points(dimensions, count);
  for (double& coordinate : points.reshaped()) {
    coordinate = random.Uniform(-5, 5);
  }
  MetricMatrix matrix;
  matrix.values.resize(count, count);
  for (Eigen::Index row = 0; row < count; ++row) {
    std::string label = "m";
    label += std::to_string(row);
    matrix.labels.push_back(label);
    for (Eigen::Index column = 0; column < count; ++column) {
      matrix.values(row, column) = (points.col(row) - points.col(column)).norm();
    }
  }
  return matrix;
}

}  // namespace cohort
