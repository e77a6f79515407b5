#include "client/proof.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/fetched_matrix.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/jobs/field_blob.h"
#include "common/pairs/pair_meter.h"

namespace cohort {
namespace {

/// A directed pair by the places of its meshes in JobFrame::Active().
using PairPlace = std::pair<size_t, size_t>;

std::vector<PairPlace> DrawPairs(size_t meshes, int64_t count, uint64_t seed) {
  const auto all = static_cast<int64_t>(meshes * meshes);
  std::set<int64_t> drawn;
  Random random(seed);
  while (count < all && std::ssize(drawn) < count) {
    drawn.insert(random.Below(all));
  }
  std::vector<PairPlace> pairs;
  for (int64_t pair = 0; count >= all && pair < all; ++pair) {
    drawn.insert(pair);
  }
  pairs.reserve(drawn.size());
  for (const int64_t pair : drawn) {
    pairs.emplace_back(static_cast<size_t>(pair) / meshes, static_cast<size_t>(pair) % meshes);
  }
  return pairs;
}

/// What the job kept of its distances: its metrics are those of the distances as kept.
absl::StatusOr<Retention> KeptRetention(const JobFrame& frame) {
  if (frame.Outputs().fields.empty()) {
    return Retention::kMetrics;
  }
  COHORT_ASSIGN_OR_RETURN(const std::string bytes,
                          frame.Blobs().Get(frame.Outputs().fields.front()));
  COHORT_ASSIGN_OR_RETURN(const FieldBlob blob, DecodeFieldBlob(bytes));
  return blob.retention;
}

absl::StatusOr<MetricValues> MeasureAgain(const JobFrame& frame,
                                          const CompareOptions& compare,
                                          const PairPlace& pair) {
  const PairMeshOptions options = {.compare = compare};
  COHORT_ASSIGN_OR_RETURN(const FramedMesh source, frame.Load(frame.Active()[pair.first], options));
  COHORT_ASSIGN_OR_RETURN(const FramedMesh target,
                          frame.Load(frame.Active()[pair.second], options));
  PairMeter meter(compare);
  COHORT_ASSIGN_OR_RETURN(
      const MeasuredPair measured,
      meter.Measure(source.placed.vertices, {.vertices = target.placed.vertices,
                                             .unplaced = target.placed.unplaced.get(),
                                             .surface = target.placed.surface.get()}));
  return measured.metrics;
}

}  // namespace

absl::StatusOr<PairProof> ProvePairs(
    Session& session, const JobFrame& frame, int64_t count, uint64_t seed, Executor& executor) {
  COHORT_RETURN_IF_ERROR(frame.CheckHasFrame());
  CompareOptions compare = frame.GetJob().spec.compare;
  COHORT_ASSIGN_OR_RETURN(compare.retention, KeptRetention(frame));
  const std::vector<PairPlace> pairs = DrawPairs(frame.Active().size(), count, seed);
  std::vector<MetricValues> again(pairs.size());
  std::vector<absl::Status> statuses(pairs.size());
  executor.ParallelFor(std::ssize(pairs), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    const absl::StatusOr<MetricValues> measured = MeasureAgain(frame, compare, pairs[place]);
    statuses[place] = measured.status();
    if (measured.ok()) {
      again[place] = *measured;
    }
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  PairProof result;
  result.pairs = std::ssize(pairs);
  result.of = std::ssize(frame.Active()) * std::ssize(frame.Active());
  const auto name = [&](size_t place) -> const std::string& {
    return frame.Meshes()[static_cast<size_t>(frame.Active()[place])].mesh.name;
  };
  for (const Metric metric : kAllMetrics) {
    COHORT_ASSIGN_OR_RETURN(const LargeMatrix matrix,
                            FetchMatrix(session, frame.GetJob().id, metric, frame.Meshes()));
    const MatrixView view = matrix.View();
    for (size_t i = 0; i < pairs.size(); ++i) {
      const auto [source, target] = pairs[i];
      const double first =
          view.values(static_cast<Eigen::Index>(source), static_cast<Eigen::Index>(target));
      const double second = again[i][static_cast<size_t>(metric)];
      ++result.numbers;
      if (std::bit_cast<uint64_t>(first) != std::bit_cast<uint64_t>(second) &&
          !(std::isnan(first) && std::isnan(second))) {
        result.differences.push_back(absl::StrCat(name(source), " to ", name(target), ", ",
                                                  std::string(MetricName(metric)), ": ", first,
                                                  " in the results, ", second, " now"));
      }
    }
  }
  return result;
}

}  // namespace cohort
