#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

namespace cohort {

/// Path of the search kernels. All give the same bytes.
enum class InstructionSet { kPortable, kAvx2, kAvx512 };

/// "portable", "avx2", "avx512".
[[nodiscard]] std::string_view InstructionSetName(InstructionSet set);
/// Those that this build holds and this machine runs, slowest first; never empty.
[[nodiscard]] std::vector<InstructionSet> AvailableInstructionSets();

/// The path asked for by COHORT_ISA, or else the fastest available. Looked up at every call.
/// @return kInvalidArgument if COHORT_ISA names no path, kFailedPrecondition if this machine or
/// this
///         build does not have it; both list what there is.
[[nodiscard]] absl::StatusOr<InstructionSet> ChooseInstructionSet();

}  // namespace cohort
