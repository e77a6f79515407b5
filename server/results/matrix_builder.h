#pragma once

#include <functional>
#include <vector>

#include <absl/status/status.h>

#include "common/geometry/comparison/metrics.h"
#include "common/jobs/job_state.h"
#include "common/jobs/preview_blobs.h"
#include "common/store/blob_store.h"

namespace cohort {

/// Directed values of one metric for sources x targets.
struct MatrixBlock {
  std::vector<int32_t> sources;
  std::vector<int32_t> targets;
  std::vector<double> values;  ///< Row by row.
};

/// Calls `consume` with every block of the metric matrix, reading one tile blob at a time, so that
/// memory stays bounded whatever the number of meshes. Stops at the first false.
/// @return as BlobStore::Get and DecodeTileBlob.
[[nodiscard]] absl::Status ForEachMatrixBlock(
    BlobStore& store,
    const JobOutputs& outputs,
    Metric metric,
    const std::function<bool(const MatrixBlock&)>& consume);

/// The same of the preview, whose values are undirected: a block of two different sets of meshes
/// stands for its transpose too.
/// @return as BlobStore::Get and DecodePreviewBlob.
[[nodiscard]] absl::Status ForEachPreviewBlock(
    BlobStore& store,
    const JobOutputs& outputs,
    const std::function<bool(const PreviewBlock&)>& consume);

}  // namespace cohort
