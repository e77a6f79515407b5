#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <absl/strings/str_cat.h>

#include "tests/bench/figures.h"

namespace cohort {

/// Largest error of distances: issue 3 allows 2e-6 of the distance + 1e-6 mm.
class ErrorMeter {
 public:
  /// @param squared_distance  ours, float32.
  /// @param true_squared_distance  in double, from the same float32 coordinates.
  void Add(float squared_distance, double true_squared_distance) {
    const double truth = std::sqrt(true_squared_distance);
    const double error = std::abs(std::sqrt(static_cast<double>(squared_distance)) - truth);
    largest_ = std::max(largest_, error);
    largest_share_ = std::max(largest_share_, error / (2e-6 * truth + 1e-6));
  }

  /// @param truth  who computed the true distances.
  [[nodiscard]] Figure ToFigure(std::string name, std::string_view truth) const {
    return {std::move(name), AtMost(1), largest_share_, " of what is allowed",
            absl::StrCat("largest error ", Digits(largest_), " mm against ", std::string(truth))};
  }

 private:
  double largest_ = 0;
  double largest_share_ = 0;
};

}  // namespace cohort
