#include "server/planning/kept_bytes.h"

namespace cohort {

double BytesKept(const PlanState& state, Retention retention) {
  constexpr double kVectorBytes = 3.3;
  constexpr double kCompactBytes = 1.7;
  constexpr double kSketchBytes = 700;
  const auto meshes = static_cast<double>(state.ActiveCount());
  const double distances = state.active_vertices * meshes;
  switch (retention) {
    case Retention::kVectors:
      return distances * kVectorBytes;
    case Retention::kCompact:
      return distances * kCompactBytes;
    case Retention::kSketch:
      return meshes * meshes * kSketchBytes;
    case Retention::kMetrics:
    case Retention::kAuto:
      break;
  }
  return 0;
}

CompareOptions ResolvedCompare(const PlanState& state) {
  CompareOptions compare = state.spec.compare;
  if (compare.retention == Retention::kAuto) {
    compare.retention = Retention::kMetrics;
    for (const Retention richer : {Retention::kSketch, Retention::kCompact, Retention::kVectors}) {
      // The predecessor's distances are kept whole or not at all.
      if (state.spec.arithmetic == Arithmetic::kFidentis && richer != Retention::kVectors) {
        continue;
      }
      if (BytesKept(state, richer) <= static_cast<double>(state.spec.retention_budget)) {
        compare.retention = richer;
      }
    }
  }
  return compare;
}

}  // namespace cohort
