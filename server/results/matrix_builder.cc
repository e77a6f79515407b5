#include "server/results/matrix_builder.h"

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"

namespace cohort {

absl::Status ForEachMatrixBlock(BlobStore& store,
                                const JobOutputs& outputs,
                                Metric metric,
                                const std::function<bool(const MatrixBlock&)>& consume) {
  for (const Digest& tile : outputs.tiles) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(tile));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MetricBlock> blocks, DecodeTileBlob(bytes));
    for (const MetricBlock& block : blocks) {
      MatrixBlock values{.sources = block.sources, .targets = block.targets, .values = {}};
      values.values.reserve(block.values.size());
      for (const MetricValues& pair : block.values) {
        values.values.push_back(pair[static_cast<size_t>(metric)]);
      }
      if (!consume(values)) {
        return absl::OkStatus();
      }
    }
  }
  return absl::OkStatus();
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
