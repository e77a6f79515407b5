#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/evaluation/findings.h"
#include "client/evaluation/lab.h"
#include "common/analysis/identification.h"
#include "common/base/executor.h"

namespace cohort {

/// The thesis's three strategies, in its order.
inline constexpr std::array<Method, 3> kStrategies = {Method::kEach, Method::kOne,
                                                      Method::kAverage};
inline constexpr size_t kEach = 0;
inline constexpr size_t kOne = 1;
inline constexpr size_t kAverage = 2;
inline constexpr int kTriad = 3;  ///< Neighbours.

/// The meshes of an evaluation at one density of vertices, and the runs with the thesis's defaults.
struct Density {
  std::string set;
  std::string name;                  ///< Of the folder.
  std::vector<MeshFile> files;       ///< By name.
  double vertices = 0;               ///< Mean of a mesh; known after the first run.
  std::array<Experiment, 3> runs;    ///< I = 40, e = 0.05; by kStrategies.
  std::array<Experiment, 3> forced;  ///< I = 60, e = 0: all iterations run.
};

/// What the parts of an evaluation share.
struct Evaluation {
  std::filesystem::path data;      ///< Folder for the servers' data.
  std::vector<Density> densities;  ///< Ascending vertices.
  bool has_persons = false;
  Executor& executor;
  std::function<void(const std::string&)> say;  ///< Progress, one line.
  Findings findings;

  [[nodiscard]] int64_t MeshCount() const { return std::ssize(densities.front().files); }
  /// The one in the middle: the thesis's 10k of 5k, 10k, 20k.
  [[nodiscard]] Density& Middle() { return densities[densities.size() / 2]; }
  /// Persons of the rows of a matrix.
  [[nodiscard]] Identities IdentitiesOf(const MetricMatrix& matrix) const;
};

/// "To Each", "To One", "To Average".
[[nodiscard]] std::string StrategyName(size_t strategy);

// The parts, in the order in which they must run. Each adds tables, properties and pictures.
/// Tables 5.1-5.6, figures 5.3 and 5.4; fills Density::runs and forced. Starts its own labs.
[[nodiscard]] absl::Status EvaluateSpeed(Evaluation& evaluation);
/// Tables 5.7-5.15, figures 5.5 and 5.6.
[[nodiscard]] absl::Status EvaluateNeighbours(Evaluation& evaluation, Lab& lab);
/// Figures 5.7-5.10.
[[nodiscard]] absl::Status EvaluateMeanShape(Evaluation& evaluation, Lab& lab);
/// Figures 2.4, 3.3 and 3.6; what the converged default does better.
[[nodiscard]] absl::Status EvaluateAccuracy(Evaluation& evaluation, Lab& lab);

}  // namespace cohort
