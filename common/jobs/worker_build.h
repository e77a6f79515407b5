#pragma once

#include <string>

namespace cohort {

/// What a worker and its server must have in common: BuildVersion and, because builds between two
/// releases share that, kResultsVersion. "0.1.0 (results 4)".
[[nodiscard]] std::string WorkerBuild();

}  // namespace cohort
