#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/analysis.h"
#include "client/analysis_input.h"
#include "common/report/job_json.h"

namespace cohort {

/// A dozen lines for people; numbers rounded.
[[nodiscard]] std::string AnalysisToText(const AnalysisInput& input,
                                         const AnalysisOptions& options,
                                         const Analysis& analysis);

/// Everything that fits no table, in full; tables are in the files. NaN and infinity are null.
[[nodiscard]] nlohmann::ordered_json AnalysisToJson(const AnalysisInput& input,
                                                    const AnalysisOptions& options,
                                                    const Analysis& analysis);

}  // namespace cohort
