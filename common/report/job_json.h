#pragma once

#include <string>
#include <vector>

#include "common/jobs/job_state.h"

namespace cohort {

/// A file of the results folder, for people.
struct ResultFile {
  std::string name;         ///< Relative to the folder.
  std::string description;  ///< One line.
  std::string unit;         ///< Of the numbers in it, e.g. "mm"; empty: none.
};

struct JobJsonInput {
  Job job;
  std::vector<JobMesh> meshes;  ///< The job's order.
  std::vector<ResultFile> files;
  std::vector<std::string> notes;  ///< What people must know of the results; one line each.
  std::string software_version;    ///< E.g. "cohort 0.1.0".
  std::string host;                ///< Where the job was run or fetched.
};

/// job.json: what was computed from what, with which result.
///
/// Two spaces of indentation, keys in a fixed order, UTF-8. What differs between two runs of the
/// same work (times, host) is in the object "run" and nowhere else: {host, created, started,
/// finished (ISO 8601, UTC; null: never), seconds (from start to finish; null: not both)}. The id
/// of a job is the server's and may differ too. "totals" sums the counters: over all stages, and
/// over align + average as the thesis counts (tables 5.4-5.5).
[[nodiscard]] std::string JobJson(const JobJsonInput& input);

/// "2026-03-01T12:34:56.789Z".
[[nodiscard]] std::string Iso8601Utc(int64_t unix_ms);

}  // namespace cohort
