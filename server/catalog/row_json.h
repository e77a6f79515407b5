#pragma once

#include <map>
#include <string>

#include <absl/status/statusor.h>

#include "common/jobs/job_state.h"
#include "common/jobs/task.h"

namespace cohort {

// Values as the text of one column. Every parse returns kDataLoss naming what is wrong with the
// text: it was written by us. By this build or an earlier one: a field that is missing takes its
// default, an unknown one (of a newer build) is refused.

[[nodiscard]] std::string LabelsToText(const std::map<std::string, std::string>& labels);
[[nodiscard]] absl::StatusOr<std::map<std::string, std::string>> LabelsFromText(
    const std::string& text);

[[nodiscard]] std::string SpecToText(const JobSpec& spec);
[[nodiscard]] absl::StatusOr<JobSpec> SpecFromText(const std::string& text);

[[nodiscard]] std::string ProgressToText(const Progress& progress);
[[nodiscard]] absl::StatusOr<Progress> ProgressFromText(const std::string& text);

[[nodiscard]] std::string CountersToText(const Counters& counters);
[[nodiscard]] absl::StatusOr<Counters> CountersFromText(const std::string& text);

[[nodiscard]] std::string OutputsToText(const JobOutputs& outputs);
[[nodiscard]] absl::StatusOr<JobOutputs> OutputsFromText(const std::string& text);

[[nodiscard]] std::string ResultToText(const TaskResult& result);
[[nodiscard]] absl::StatusOr<TaskResult> ResultFromText(const std::string& text);

/// Without the index: it belongs to one job.
[[nodiscard]] std::string IngestedToText(const IngestedMesh& mesh);
[[nodiscard]] absl::StatusOr<IngestedMesh> IngestedFromText(const std::string& text);

/// What became of a mesh in its job, without its index: `ingested` and `copy`; the empty text if it
/// was not ingested.
[[nodiscard]] std::string OutcomeToText(const JobMesh& mesh);
/// Sets `ingested` and `copy` of `mesh`.
[[nodiscard]] absl::Status OutcomeFromText(const std::string& text, int32_t index, JobMesh& mesh);

/// The empty digest is the empty text.
[[nodiscard]] absl::StatusOr<Digest> DigestFromText(const std::string& text);

}  // namespace cohort
