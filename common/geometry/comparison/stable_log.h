#pragma once

namespace cohort {

/// Logarithm and exponential built from +, -, *, / and exact scaling only, so that a geometric mean
/// has the same bits on every machine; the C library picks other code for other processors, which
/// may differ in the last bit. Accurate to a few units in the last place.
/// Source: ours (range reduction; series of the inverse hyperbolic tangent, Taylor polynomial).

/// ln x; x > 0 and finite, -infinity at 0.
[[nodiscard]] double StableLog(double x);
/// e^x; 0 below -745 (and at -infinity), infinity above 710.
[[nodiscard]] double StableExp(double x);

}  // namespace cohort
