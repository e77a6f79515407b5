#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "client/results_folder.h"
#include "common/jobs/job_state.h"

namespace cohort {

/// A job for scripts (`--json`).
[[nodiscard]] nlohmann::json JobToJson(const Job& job);

/// A job for people: a few lines.
[[nodiscard]] std::string JobToText(const Job& job);

/// Jobs as an aligned table, one a line.
[[nodiscard]] std::string JobsToTable(const std::vector<Job>& jobs);

/// The last words of `run` and `results`: rejected files, where the results are, what to open
/// first.
[[nodiscard]] std::string ResultsToText(const ResultsDigest& results, const std::string& folder);

/// The same for scripts.
[[nodiscard]] nlohmann::json ResultsToJson(const ResultsDigest& results, const std::string& folder);

}  // namespace cohort
