#pragma once

#include <vector>

#include <absl/status/statusor.h>

#include "common/jobs/job_state.h"
#include "common/store/blob_store.h"

namespace cohort {

/// What a new job over `meshes` keeps of a finished one.
///
/// Kept are the meshes of the same name and bytes that the reference job has accepted: their
/// alignments and the pairs among them. What was deleted costs nothing but its rows.
struct ReferenceFrame {
  JobSpec spec;     ///< The reference job's options with what the new job may choose.
  JobOutputs kept;  ///< For JobPlan::Create.
};

/// @param reference  succeeded; with its meshes and outputs.
/// @param wanted  the new job's: metric, symmetrization, neighbours, priority and fresh count.
/// @param store  takes a blob of the kept alignments under the new job's indices.
/// @return kFailedPrecondition (REFERENCE_UNUSABLE) if the reference job has not succeeded or is of
///         a kind whose results cannot be added to; kInvalidArgument if nothing would be kept.
[[nodiscard]] absl::StatusOr<ReferenceFrame> MakeReferenceFrame(
    const Job& reference,
    const std::vector<JobMesh>& reference_meshes,
    const JobOutputs& outputs,
    const JobSpec& wanted,
    const std::vector<SetMesh>& meshes,
    BlobStore& store);

}  // namespace cohort
