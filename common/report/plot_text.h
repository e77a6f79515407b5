#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cohort {

/// Width of a text as it would be drawn.
using MeasureText = std::function<double(const std::string&)>;

/// Labels that fit into `max_width`.
///
/// If one is too long, what all begin and end with is left out first (that is what file names of a
/// study share); what is still too long loses its middle. "…" stands where something is missing.
/// @return as many as `labels`, printable UTF-8.
[[nodiscard]] std::vector<std::string> FittedLabels(std::span<const std::string> labels,
                                                    double max_width,
                                                    const MeasureText& width);

}  // namespace cohort
