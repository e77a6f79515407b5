#include "server/planning/job_forecast.h"

#include <algorithm>

#include "server/planning/kept_bytes.h"

namespace cohort {
namespace {

// Bytes as the formats of common/jobs and common/store have them; job_forecast_test.cc and
// tests/e2e hold the sum against what jobs write.
constexpr double kMeshBytes = 8;           ///< A vertex of a canonical mesh, with its faces.
constexpr double kMetricsBytes = 56;       ///< A directed pair.
constexpr double kShapeBytes = 48;         ///< A vertex of a mean shape: as computed, not rounded.
constexpr double kSummaryBytes = 56;       ///< A vertex of the reference.
constexpr double kDisplacementBytes = 12;  ///< A vertex of the reference and a batch.
constexpr double kVariationBytes = 4;      ///< A vertex of the reference and a mesh.
constexpr double kCorrespondenceBytes = 12;  ///< The same of a preview.
constexpr double kSignatureBytes = 3072;     ///< A mesh.
constexpr double kPreviewBytes = 8;          ///< An undirected pair.
constexpr double kAlignmentBytes = 200;      ///< A mesh and a round.

double OtherBytes(const PlanState& state, double measured_pairs) {
  const auto meshes = static_cast<double>(state.ActiveCount());
  const double reference = state.VerticesOf(state.base);
  double bytes = measured_pairs * kMetricsBytes + meshes * reference * kVariationBytes;
  bytes += meshes * kSignatureBytes;
  for (const int32_t mesh : state.active) {
    const bool is_new = !state.meshes[static_cast<size_t>(mesh)].ingested;
    const int copies = (is_new ? 1 : 0) + (state.spec.symmetric_copies ? 1 : 0);
    bytes += copies * state.VerticesOf(mesh) * kMeshBytes;
  }
  const int rounds = state.spec.method == Method::kAverage ? state.spec.rounds : 0;
  const auto batches = static_cast<double>(state.batches.size());
  // Of each round or, where there is none, of the variation.
  bytes += std::max(rounds, 1) * reference * batches * kDisplacementBytes;
  bytes += (rounds + 1) * reference * kShapeBytes;
  bytes += reference * kSummaryBytes;
  bytes += (rounds + 2) * meshes * kAlignmentBytes;
  if (state.spec.method == Method::kEach) {
    bytes += meshes * meshes * kAlignmentBytes;
  }
  if (state.spec.preview) {
    bytes += meshes * reference * kCorrespondenceBytes + meshes * meshes / 2 * kPreviewBytes;
  }
  return bytes;
}

}  // namespace

JobForecast ForecastOf(const PlanState& state) {
  JobForecast forecast;
  const int64_t meshes = state.ActiveCount();
  const int64_t kept = state.HasKeptFrame() ? std::ssize(state.active_kept) : 0;
  forecast.meshes = meshes;
  forecast.pairs = meshes * (meshes - 1) - kept * (kept - 1);
  forecast.retention = ResolvedCompare(state).retention;
  // A tile measures its meshes against themselves, too.
  const auto measured = static_cast<double>(meshes * meshes - kept * kept);
  const double share = measured / static_cast<double>(meshes * meshes);
  for (const Retention retention :
       {Retention::kVectors, Retention::kCompact, Retention::kSketch, Retention::kMetrics}) {
    forecast.distance_bytes[retention] = BytesKept(state, retention) * share;
  }
  forecast.other_bytes = OtherBytes(state, measured);
  return forecast;
}

}  // namespace cohort
