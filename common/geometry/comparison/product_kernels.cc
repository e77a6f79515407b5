#include "common/geometry/comparison/product_kernels.h"

#include <vector>

#include "common/geometry/nearest/instruction_set.h"

namespace cohort {
namespace {

bool HasVnni() {
#if defined(COHORT_X86_KERNELS)
  return __builtin_cpu_supports("avx512vnni") != 0;
#else
  return false;
#endif
}

/// Slowest first.
std::vector<const ProductKernels*> KernelsFor(InstructionSet set) {
  switch (set) {
    case InstructionSet::kPortable:
      return {PortableProductKernels()};
    case InstructionSet::kAvx2:
      return {Avx2ProductKernels()};
    case InstructionSet::kAvx512:
      return {Avx512ProductKernels(), HasVnni() ? Avx512VnniProductKernels() : nullptr};
  }
  return {};
}

void Append(InstructionSet set, std::vector<const ProductKernels*>& all) {
  for (const ProductKernels* kernels : KernelsFor(set)) {
    if (kernels != nullptr) {
      all.push_back(kernels);
    }
  }
}

std::vector<const ProductKernels*> FindRunnable() {
  std::vector<const ProductKernels*> runnable;
  for (const InstructionSet set : AvailableInstructionSets()) {
    Append(set, runnable);
  }
  return runnable;
}

/// A COHORT_ISA that cannot be had is refused by the search; here the result is the same anyway.
const ProductKernels& Choose() {
  const absl::StatusOr<InstructionSet> chosen = ChooseInstructionSet();
  std::vector<const ProductKernels*> kernels;
  if (chosen.ok()) {
    Append(*chosen, kernels);
  }
  return kernels.empty() ? *RunnableProductKernels().back() : *kernels.back();
}

}  // namespace

std::span<const ProductKernels* const> RunnableProductKernels() {
  static const std::vector<const ProductKernels*> runnable = FindRunnable();
  return runnable;
}

const ProductKernels& BestProductKernels() {
  static const ProductKernels& best = Choose();
  return best;
}

}  // namespace cohort
