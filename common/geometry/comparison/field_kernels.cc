#include "common/geometry/comparison/field_kernels.h"

#include <vector>

#include "common/geometry/nearest/instruction_set.h"

namespace cohort {
namespace {

const FieldKernels* KernelsFor(InstructionSet set) {
  switch (set) {
    case InstructionSet::kPortable:
      return PortableFieldKernels();
    case InstructionSet::kAvx2:
      return Avx2FieldKernels();
    case InstructionSet::kAvx512:
      return Avx512FieldKernels();
  }
  return nullptr;
}

std::vector<const FieldKernels*> FindRunnable() {
  std::vector<const FieldKernels*> runnable;
  for (const InstructionSet set : AvailableInstructionSets()) {
    if (KernelsFor(set) != nullptr) {
      runnable.push_back(KernelsFor(set));
    }
  }
  return runnable;
}

/// A COHORT_ISA that cannot be had is refused by the search; here the result is the same anyway.
const FieldKernels& Choose() {
  const absl::StatusOr<InstructionSet> chosen = ChooseInstructionSet();
  const FieldKernels* kernels = chosen.ok() ? KernelsFor(*chosen) : nullptr;
  return kernels != nullptr ? *kernels : *RunnableFieldKernels().back();
}

}  // namespace

std::span<const FieldKernels* const> RunnableFieldKernels() {
  static const std::vector<const FieldKernels*> runnable = FindRunnable();
  return runnable;
}

const FieldKernels& BestFieldKernels() {
  static const FieldKernels& best = Choose();
  return best;
}

}  // namespace cohort
