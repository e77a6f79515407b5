#include "common/geometry/nearest/instruction_set.h"

#include <algorithm>
#include <cstdlib>
#include <string>

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

std::string AvailableNames() {
  std::string names;
  for (const InstructionSet set : AvailableInstructionSets()) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", std::string(InstructionSetName(set)));
  }
  return names;
}

}  // namespace

std::string_view InstructionSetName(InstructionSet set) {
  switch (set) {
    case InstructionSet::kPortable:
      return "portable";
    case InstructionSet::kAvx2:
      return "avx2";
    case InstructionSet::kAvx512:
      return "avx512";
  }
  return "";
}

std::vector<InstructionSet> AvailableInstructionSets() {
  std::vector<InstructionSet> sets = {InstructionSet::kPortable};
#if defined(COHORT_X86_KERNELS)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    sets.push_back(InstructionSet::kAvx2);
    if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
        __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0) {
      sets.push_back(InstructionSet::kAvx512);
    }
  }
#endif
  return sets;
}

absl::StatusOr<InstructionSet> ChooseInstructionSet() {
  const std::vector<InstructionSet> available = AvailableInstructionSets();
  const char* const asked = std::getenv("COHORT_ISA");
  if (asked == nullptr || *asked == '\0') {
    return available.back();
  }
  for (const InstructionSet set :
       {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (asked != InstructionSetName(set)) {
      continue;
    }
    if (std::find(available.begin(), available.end(), set) == available.end()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "COHORT_ISA=", asked, ": this machine does not run it; it runs ", AvailableNames()));
    }
    return set;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "COHORT_ISA=", asked, ": no such instruction set; this machine runs ", AvailableNames()));
}

}  // namespace cohort
