#include "server/results/matrix_builder.h"

#include <algorithm>
#include <cstddef>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"

namespace cohort {
namespace {

using Consumer = std::function<bool(const MatrixBlock&)>;

MatrixBlock ValuesOf(const MetricBlock& block, Metric metric) {
  MatrixBlock values{.sources = block.sources, .targets = block.targets, .values = {}};
  values.values.reserve(block.values.size());
  for (const MetricValues& pair : block.values) {
    values.values.push_back(pair[static_cast<size_t>(metric)]);
  }
  return values;
}

/// The block under the indices of another job, without the meshes that are not in it.
/// @return kDataLoss if it names a mesh that the map does not know.
absl::StatusOr<MatrixBlock> Renumbered(const MatrixBlock& block,
                                       const std::vector<int32_t>& mesh_of) {
  MatrixBlock kept;
  const auto renumber = [&](const std::vector<int32_t>& from, std::vector<int32_t>& to) {
    std::vector<size_t> places;
    for (size_t place = 0; place < from.size(); ++place) {
      const auto mesh = static_cast<size_t>(from[place]);
      if (mesh < mesh_of.size() && mesh_of[mesh] >= 0) {
        to.push_back(mesh_of[mesh]);
        places.push_back(place);
      }
    }
    return places;
  };
  const auto is_unknown = [&](int32_t mesh) { return static_cast<size_t>(mesh) >= mesh_of.size(); };
  if (std::any_of(block.sources.begin(), block.sources.end(), is_unknown) ||
      std::any_of(block.targets.begin(), block.targets.end(), is_unknown)) {
    return absl::DataLossError("a tile of the reference job names a mesh that it does not have");
  }
  const std::vector<size_t> rows = renumber(block.sources, kept.sources);
  const std::vector<size_t> columns = renumber(block.targets, kept.targets);
  kept.values.reserve(rows.size() * columns.size());
  for (const size_t row : rows) {
    for (const size_t column : columns) {
      kept.values.push_back(block.values[row * block.targets.size() + column]);
    }
  }
  return kept;
}

/// False once the consumer has had enough.
/// @param mesh_of  null: the indices are those of the job.
absl::StatusOr<bool> ForEachBlockOf(BlobStore& store,
                                    const std::vector<Digest>& tiles,
                                    Metric metric,
                                    const std::vector<int32_t>* mesh_of,
                                    const Consumer& consume) {
  for (const Digest& tile : tiles) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(tile));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MetricBlock> blocks, DecodeTileBlob(bytes));
    for (const MetricBlock& block : blocks) {
      MatrixBlock values = ValuesOf(block, metric);
      if (mesh_of != nullptr) {
        COHORT_ASSIGN_OR_RETURN(values, Renumbered(values, *mesh_of));
      }
      if (!values.values.empty() && !consume(values)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

absl::Status ForEachMatrixBlock(BlobStore& store,
                                const JobOutputs& outputs,
                                Metric metric,
                                const Consumer& consume) {
  for (const ImportedPairs& pairs : outputs.imported) {
    COHORT_ASSIGN_OR_RETURN(const bool goes_on,
                            ForEachBlockOf(store, pairs.tiles, metric, &pairs.mesh_of, consume));
    if (!goes_on) {
      return absl::OkStatus();
    }
  }
  return ForEachBlockOf(store, outputs.tiles, metric, nullptr, consume).status();
}

absl::Status ForEachPreviewBlock(BlobStore& store,
                                 const JobOutputs& outputs,
                                 const std::function<bool(const PreviewBlock&)>& consume) {
  for (const Digest& blob : outputs.preview) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(const PreviewBlock block, DecodePreviewBlob(bytes));
    if (!consume(block)) {
      return absl::OkStatus();
    }
  }
  return absl::OkStatus();
}

}  // namespace cohort
