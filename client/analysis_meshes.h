#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/analysis_input.h"

namespace cohort {

/// "a, b, c, d, e and 4 more".
[[nodiscard]] std::string SomeOf(const std::vector<std::string>& names);

/// Puts the labels of a file in place of the job's, column by column.
/// @return kInvalidArgument if none of its files is a mesh of the matrix.
[[nodiscard]] absl::Status ReplaceLabels(const std::string& labels_file, AnalysisInput& input);

/// Puts labels that are in the names of the meshes (NamePattern) in place of those there are.
/// @return kInvalidArgument if the pattern is none, or no mesh fits it.
[[nodiscard]] absl::Status LabelByName(const std::string& pattern, AnalysisInput& input);

/// The values of a label column, "" where a mesh has none ("NA" counts as none).
/// @return kInvalidArgument, naming the columns there are, if no mesh has that one.
[[nodiscard]] absl::StatusOr<std::vector<std::string>> LabelColumn(const AnalysisInput& input,
                                                                   const std::string& column);

/// What to do with meshes that are in one matrix only.
enum class OtherMeshes { kRefuse, kLeaveOut };

/// Brings matrices to the meshes of the first, in its order.
/// @return kInvalidArgument, naming some, if a mesh is in one only and that is refused; or if under
///         three are in all.
[[nodiscard]] absl::Status MatchMeshes(std::vector<AnalysisInput>& inputs, OtherMeshes others);

}  // namespace cohort
