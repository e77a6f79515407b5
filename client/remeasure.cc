#include "client/remeasure.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/fetched_matrix.h"
#include "common/base/status_macros.h"
#include "common/jobs/field_blob.h"
#include "common/pairs/distance_finder.h"
#include "common/pairs/kept_distances.h"

namespace cohort {
namespace {

constexpr size_t kBlock = 8;  ///< Meshes whose vertices stay in the cache of a core.

/// A field blob, and which mesh of the job each of its meshes is.
struct FieldSource {
  Digest blob;
  const std::vector<int32_t>* mesh_of = nullptr;  ///< Null: the same.
};

std::vector<FieldSource> FieldSources(const JobOutputs& outputs) {
  std::vector<FieldSource> sources;
  for (const Digest& blob : outputs.fields) {
    sources.push_back({.blob = blob});
  }
  for (const ImportedPairs& imported : outputs.imported) {
    for (const Digest& blob : imported.fields) {
      sources.push_back({.blob = blob, .mesh_of = &imported.mesh_of});
    }
  }
  return sources;
}

/// One remeasuring of one job.
class Remeasurer {
 public:
  Remeasurer(const JobFrame& frame, const RemeasureOptions& options, Executor& executor)
      : frame_(frame),
        options_(options),
        executor_(executor),
        sources_(FieldSources(frame.Outputs())) {
    const auto count = std::ssize(frame.Meshes());
    result_.directed =
        RowMajorMatrix::Constant(count, count, std::numeric_limits<double>::quiet_NaN());
  }

  absl::StatusOr<Remeasured> Run(Session& session) {
    COHORT_RETURN_IF_ERROR(options_.measure.ToFieldOptions().Validate());
    COHORT_ASSIGN_OR_RETURN(result_.source, ChooseSource());
    switch (result_.source) {
      case MeasureSource::kAuto:
      case MeasureSource::kMetrics: {
        std::vector<int64_t> rows(frame_.Meshes().size());
        std::iota(rows.begin(), rows.end(), int64_t{0});
        COHORT_RETURN_IF_ERROR(session.ReadMatrix(
            frame_.GetJob().id, options_.measure.metric,
            [&](const MatrixPart& part) { return PutPart(part, rows, result_.directed); }));
        break;
      }
      case MeasureSource::kKept:
        COHORT_RETURN_IF_ERROR(MeasureKeptFields());
        break;
      case MeasureSource::kRecompute:
        COHORT_RETURN_IF_ERROR(MeasureAgain());
        break;
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool HasWeights() const {
    return options_.measure.by_area || options_.region.has_value();
  }
  [[nodiscard]] bool IsPlain() const {
    return options_.measure.IsPlainMetric() && !options_.region;
  }
  [[nodiscard]] const CompareOptions& Compare() const { return frame_.GetJob().spec.compare; }
  /// Why what was kept cannot answer; empty if it can. Sets result_.retention.
  absl::StatusOr<std::string> WhyNotKept();
  absl::StatusOr<MeasureSource> ChooseSource();
  absl::StatusOr<std::optional<RegionMask>> Region() const;
  std::vector<double> WeightsOf(const FramedMesh& mesh, const RegionMask* region) const {
    return SlotWeights(mesh.mesh, mesh.placed.vertices, options_.measure.by_area, region);
  }
  /// By index of the job's meshes; of those that are not active empty.
  absl::StatusOr<std::vector<std::vector<double>>> AllWeights() const;
  absl::Status MeasureKeptFields();
  absl::Status MeasureBlob(const FieldSource& source,
                           const std::vector<std::vector<double>>& weights,
                           double& bound);
  absl::Status MeasureAgain();
  absl::Status MeasureRows(const std::vector<FramedMesh>& meshes,
                           size_t first_row,
                           const RegionMask* region);

  const JobFrame& frame_;
  const RemeasureOptions& options_;
  Executor& executor_;
  const std::vector<FieldSource> sources_;
  Remeasured result_;
};

absl::StatusOr<std::string> Remeasurer::WhyNotKept() {
  if (sources_.empty()) {
    return std::string("it kept nothing of its distances (retention metrics)");
  }
  for (const ImportedPairs& imported : frame_.Outputs().imported) {
    if (imported.fields.empty() && !imported.tiles.empty()) {
      return std::string("some of its pairs are of an earlier job that kept nothing of them");
    }
  }
  if (frame_.Outputs().fields.empty() && !frame_.Outputs().tiles.empty()) {
    return std::string("some of its pairs are kept without their distances");
  }
  if (options_.measure.sign == DistanceSign::kSigned && Compare().sign == DistanceSign::kAbsolute) {
    return std::string("it kept distances without their signs");
  }
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, frame_.Blobs().Get(sources_.front().blob));
  COHORT_ASSIGN_OR_RETURN(const FieldBlob first, DecodeFieldBlob(bytes));
  result_.retention = first.retention;
  if (HasWeights() && first.retention == Retention::kSketch) {
    return std::string("it kept sketches, which do not know which vertex a distance is of");
  }
  if (HasWeights() && Compare().boundary_pairs == BoundaryPairs::kReject) {
    return std::string("it left out pairs at the boundary and did not keep which");
  }
  return std::string();
}

absl::StatusOr<MeasureSource> Remeasurer::ChooseSource() {
  const std::string job = "job " + frame_.GetJob().id.value;
  const bool may_keep = options_.source == MeasureSource::kKept ||
                        (options_.source == MeasureSource::kAuto && !IsPlain());
  if (options_.source == MeasureSource::kMetrics && !IsPlain()) {
    return absl::FailedPreconditionError(
        job + ": that is none of the seven metrics that every job has; leave out --source");
  }
  if (!may_keep) {
    return options_.source == MeasureSource::kAuto ? MeasureSource::kMetrics : options_.source;
  }
  COHORT_ASSIGN_OR_RETURN(const std::string why_not, WhyNotKept());
  if (why_not.empty()) {
    return MeasureSource::kKept;
  }
  if (options_.source == MeasureSource::kKept) {
    return absl::FailedPreconditionError(
        absl::StrCat(job, " cannot be measured from what it kept: ", why_not,
                     "; --source recompute finds the distances once more"));
  }
  return MeasureSource::kRecompute;
}

absl::StatusOr<std::optional<RegionMask>> Remeasurer::Region() const {
  if (!options_.region) {
    return std::optional<RegionMask>();
  }
  COHORT_ASSIGN_OR_RETURN(RegionMask region, frame_.MakeRegion(*options_.region));
  return std::optional<RegionMask>(std::move(region));
}

absl::StatusOr<std::vector<std::vector<double>>> Remeasurer::AllWeights() const {
  std::vector<std::vector<double>> weights(frame_.Meshes().size());
  if (!HasWeights()) {
    return weights;
  }
  COHORT_ASSIGN_OR_RETURN(const std::optional<RegionMask> region, Region());
  const std::vector<int32_t>& active = frame_.Active();
  std::vector<absl::Status> statuses(active.size());
  executor_.ParallelFor(std::ssize(active), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    const absl::StatusOr<FramedMesh> mesh = frame_.Load(active[place], {.compare = Compare()});
    statuses[place] = mesh.status();
    if (mesh.ok()) {
      weights[static_cast<size_t>(active[place])] = WeightsOf(*mesh, region ? &*region : nullptr);
    }
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  return weights;
}

absl::Status Remeasurer::MeasureKeptFields() {
  COHORT_ASSIGN_OR_RETURN(const auto weights, AllWeights());
  std::vector<absl::Status> statuses(sources_.size());
  std::vector<double> bounds(sources_.size(), 0.0);
  executor_.ParallelFor(std::ssize(sources_), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    statuses[place] = MeasureBlob(sources_[place], weights, bounds[place]);
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  result_.largest_bound = *std::max_element(bounds.begin(), bounds.end());
  return absl::OkStatus();
}

absl::Status Remeasurer::MeasureBlob(const FieldSource& source,
                                     const std::vector<std::vector<double>>& weights,
                                     double& bound) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, frame_.Blobs().Get(source.blob));
  COHORT_ASSIGN_OR_RETURN(const FieldBlob blob, DecodeFieldBlob(bytes));
  const auto meshes = std::ssize(frame_.Meshes());
  const auto index_of = [&](int32_t mesh) -> int32_t {
    if (source.mesh_of == nullptr) return mesh < meshes ? mesh : -1;
    return mesh < std::ssize(*source.mesh_of) ? (*source.mesh_of)[static_cast<size_t>(mesh)] : -1;
  };
  for (const FieldBlock& block : blob.blocks) {
    for (size_t row = 0; row < block.sources.size(); ++row) {
      for (size_t column = 0; column < block.targets.size(); ++column) {
        const int32_t from = index_of(block.sources[row]);
        const int32_t to = index_of(block.targets[column]);
        if (from < 0 || to < 0) {
          continue;  // A mesh of the earlier job that is not in this one.
        }
        COHORT_ASSIGN_OR_RETURN(
            const PairValue value,
            MeasureKept(block.fields[row * block.targets.size() + column], blob.retention,
                        weights[static_cast<size_t>(from)], options_.measure));
        result_.directed(from, to) = value.value;
        bound = std::max(bound, value.bound);
      }
    }
  }
  return absl::OkStatus();
}

absl::Status Remeasurer::MeasureAgain() {
  COHORT_ASSIGN_OR_RETURN(
      const std::vector<FramedMesh> meshes,
      frame_.LoadAll({.compare = Compare(), .sign = options_.measure.sign}, executor_));
  COHORT_ASSIGN_OR_RETURN(const std::optional<RegionMask> region, Region());
  const size_t blocks = (meshes.size() + kBlock - 1) / kBlock;
  std::vector<absl::Status> statuses(blocks);
  executor_.ParallelFor(static_cast<int64_t>(blocks), [&](int64_t i) {
    const auto block = static_cast<size_t>(i);
    statuses[block] = MeasureRows(meshes, block * kBlock, region ? &*region : nullptr);
  });
  return FirstError(statuses);
}

absl::Status Remeasurer::MeasureRows(const std::vector<FramedMesh>& meshes,
                                     size_t first_row,
                                     const RegionMask* region) {
  DistanceFinder finder(Compare(), options_.measure.sign);
  const size_t end_row = std::min(meshes.size(), first_row + kBlock);
  std::vector<std::vector<double>> weights(end_row - first_row);
  if (HasWeights()) {
    for (size_t row = first_row; row < end_row; ++row) {
      weights[row - first_row] = WeightsOf(meshes[row], region);
    }
  }
  std::vector<double> counted;
  const auto measure = [&](size_t row, size_t column) -> absl::Status {
    const PairDistances& found = finder.Find(meshes[row].placed, meshes[column].placed);
    counted.clear();
    if (HasWeights()) {
      for (const int32_t slot : found.slots) {
        counted.push_back(weights[row - first_row][static_cast<size_t>(slot)]);
      }
    }
    COHORT_ASSIGN_OR_RETURN(const PairValue value,
                            MeasurePair(found.distances, counted, options_.measure));
    result_.directed(frame_.Active()[row], frame_.Active()[column]) = value.value;
    return absl::OkStatus();
  };
  for (size_t first = 0; first < meshes.size(); first += kBlock) {
    for (size_t row = first_row; row < end_row; ++row) {
      for (size_t column = first; column < std::min(meshes.size(), first + kBlock); ++column) {
        COHORT_RETURN_IF_ERROR(measure(row, column));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Remeasured> Remeasure(Session& session,
                                     const JobFrame& frame,
                                     const RemeasureOptions& options,
                                     Executor& executor) {
  return Remeasurer(frame, options, executor).Run(session);
}

std::string MeasureSourceName(MeasureSource source) {
  switch (source) {
    case MeasureSource::kAuto:
      return "auto";
    case MeasureSource::kMetrics:
      return "metrics";
    case MeasureSource::kKept:
      return "kept";
    case MeasureSource::kRecompute:
      return "recompute";
  }
  return "";
}

}  // namespace cohort
