#pragma once

#include <string>

#include <absl/status/statusor.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/analysis_input.h"

namespace cohort {

/// Options of the commands that read matrices: which metric, how it becomes undirected.
struct MatrixFlags {
  std::string metric;
  std::string symmetrize;

  /// Adds --metric and --symmetrize.
  void AddTo(CLI::App& command);
  /// @return kInvalidArgument for a name that is not known.
  [[nodiscard]] absl::StatusOr<AnalysisSource> ToSource(const std::string& source,
                                                        const std::string& server) const;
};

/// Two spaces of indentation, line end; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string AsText(const nlohmann::ordered_json& json);

}  // namespace cohort
