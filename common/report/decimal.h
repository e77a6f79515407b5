#pragma once

#include <string>

namespace cohort {

/// Shortest decimal that reads back as the same double, with '.', e.g. "0.1", "1e-07"; "NA" for NaN
/// (what R and spreadsheets take for "missing"), "Inf" and "-Inf". The locale has no influence.
[[nodiscard]] std::string ShortestDecimal(double value);

/// `digits` (0..12) after the point, e.g. "1.50"; "NA" for NaN. For people, not for round trips.
[[nodiscard]] std::string FixedDecimal(double value, int digits);

/// About `digits` (1..12) significant digits, trailing zeros kept: "1.50", "0.0123", "1.2e+07" for
/// what would be longer than people read. "NA" for NaN.
[[nodiscard]] std::string ReadableDecimal(double value, int digits);

}  // namespace cohort
