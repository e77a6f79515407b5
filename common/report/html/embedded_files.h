#pragma once

#include <string_view>

namespace cohort {

// report.css and report.js; CMake makes them constants.
extern const std::string_view kReportStyle;
extern const std::string_view kReportScript;

}  // namespace cohort
