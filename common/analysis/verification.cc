#include "common/analysis/verification.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/analysis/labelled_pairs.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double Share(int64_t part, size_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

int64_t AtOrBelow(const std::vector<double>& ascending, double threshold) {
  return std::upper_bound(ascending.begin(), ascending.end(), threshold) - ascending.begin();
}

struct Moments {
  double mean = 0;
  double variance = 0;
};

Moments MomentsOf(const std::vector<double>& values) {
  Moments moments;
  for (const double value : values) {
    moments.mean += value;
  }
  moments.mean /= static_cast<double>(values.size());
  for (const double value : values) {
    moments.variance += (value - moments.mean) * (value - moments.mean);
  }
  moments.variance /= static_cast<double>(values.size());
  return moments;
}

double DPrime(const VerificationScores& scores) {
  const Moments genuine = MomentsOf(scores.genuine);
  const Moments impostor = MomentsOf(scores.impostor);
  return std::abs(genuine.mean - impostor.mean) /
         std::sqrt(0.5 * (genuine.variance + impostor.variance));
}

/// Which of the classes have values between two points of the staircase.
enum class StepKind { kFirst, kGenuine, kImpostor, kBoth };

StepKind KindOfStep(const ErrorRates& before, const ErrorRates& after) {
  const bool genuine = after.false_reject_rate != before.false_reject_rate;
  const bool impostor = after.false_accept_rate != before.false_accept_rate;
  return genuine && impostor ? StepKind::kBoth : genuine ? StepKind::kGenuine : StepKind::kImpostor;
}

/// Calls `on_rates` with the rates at each distinct value, ascending.
template <typename OnRates>
void ForEachThreshold(const VerificationScores& scores, const OnRates& on_rates) {
  const std::vector<double>& genuine = scores.genuine;
  const std::vector<double>& impostor = scores.impostor;
  size_t g = 0;
  size_t i = 0;
  while (g < genuine.size() || i < impostor.size()) {
    const double threshold = std::min(g < genuine.size() ? genuine[g] : kInfinity,
                                      i < impostor.size() ? impostor[i] : kInfinity);
    while (g < genuine.size() && genuine[g] == threshold) {
      ++g;
    }
    while (i < impostor.size() && impostor[i] == threshold) {
      ++i;
    }
    on_rates(ErrorRates{threshold, Share(static_cast<int64_t>(i), impostor.size()),
                        Share(static_cast<int64_t>(genuine.size() - g), genuine.size())});
  }
}

/// Where FAR = FRR on the polyline: it rises in one and falls in the other, so there is one place.
double EqualErrorRate(const std::vector<ErrorRates>& roc) {
  for (size_t p = 1; p < roc.size(); ++p) {
    const double before = roc[p - 1].false_reject_rate - roc[p - 1].false_accept_rate;
    const double after = roc[p].false_reject_rate - roc[p].false_accept_rate;
    if (after <= 0) {
      const double part = before / (before - after);
      return roc[p - 1].false_accept_rate +
             part * (roc[p].false_accept_rate - roc[p - 1].false_accept_rate);
    }
  }
  return roc.back().false_accept_rate;
}

double AreaUnder(const std::vector<ErrorRates>& roc) {
  double area = 0;
  for (size_t p = 1; p < roc.size(); ++p) {
    area += (roc[p].false_accept_rate - roc[p - 1].false_accept_rate) *
            (1 - 0.5 * (roc[p].false_reject_rate + roc[p - 1].false_reject_rate));
  }
  return area;
}

double Apart(const ErrorRates& rates) {
  return std::abs(rates.false_accept_rate - rates.false_reject_rate);
}

std::vector<int64_t> CountInBins(const std::vector<double>& values,
                                 double first,
                                 double width,
                                 int bins) {
  std::vector<int64_t> counts(static_cast<size_t>(bins));
  for (const double value : values) {
    const int bin = width > 0 ? static_cast<int>((value - first) / width) : 0;
    ++counts[static_cast<size_t>(std::clamp(bin, 0, bins - 1))];
  }
  return counts;
}

}  // namespace

absl::StatusOr<VerificationScores> CollectScores(const MetricMatrix& matrix,
                                                 const Identities& identities,
                                                 Gallery gallery) {
  COHORT_RETURN_IF_ERROR(RequireDissimilarities(matrix, 2));
  COHORT_ASSIGN_OR_RETURN(const LabelledPairs pairs,
                          LabelledPairs::Create(matrix.values.rows(), identities, gallery));
  VerificationScores scores;
  for (int64_t row = 0; row < matrix.values.rows(); ++row) {
    for (int64_t column = 0; column < row; ++column) {
      const PairKind kind = pairs.KindOf(row, column);
      const double value = matrix.values(row, column);
      if (kind == PairKind::kUnknown) {
        ++scores.unknown;
      } else if (kind == PairKind::kSameSession) {
        ++scores.same_session;
      } else if (std::isnan(value)) {
        ++scores.missing;
      } else {
        (kind == PairKind::kGenuine ? scores.genuine : scores.impostor).push_back(value);
      }
    }
  }
  std::sort(scores.genuine.begin(), scores.genuine.end());
  std::sort(scores.impostor.begin(), scores.impostor.end());
  return scores;
}

ErrorRates RatesAt(const VerificationScores& scores, double threshold) {
  return {threshold, Share(AtOrBelow(scores.impostor, threshold), scores.impostor.size()),
          Share(std::ssize(scores.genuine) - AtOrBelow(scores.genuine, threshold),
                scores.genuine.size())};
}

ErrorRates RatesAtFalseAccepts(const VerificationScores& scores, double false_accept_rate) {
  ErrorRates best = RatesAt(scores, -kInfinity);
  ForEachThreshold(scores, [&](const ErrorRates& rates) {
    if (rates.false_accept_rate <= false_accept_rate) {
      best = rates;
    }
  });
  return best;
}

absl::StatusOr<Verification> VerifyPairs(const VerificationScores& scores) {
  if (scores.genuine.empty() || scores.impostor.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("verification needs pairs of one person and of two, there are ",
                     scores.genuine.size(), " and ", scores.impostor.size()));
  }
  Verification verification;
  std::vector<ErrorRates>& roc = verification.roc;
  roc.push_back(RatesAt(scores, -kInfinity));
  verification.nearest_equal = roc.back();
  StepKind last = StepKind::kFirst;
  ForEachThreshold(scores, [&](const ErrorRates& rates) {
    if (Apart(rates) < Apart(verification.nearest_equal)) {
      verification.nearest_equal = rates;
    }
    const StepKind kind = KindOfStep(roc.back(), rates);
    // A run in one direction is one line.
    if (kind == last && kind != StepKind::kBoth) {
      roc.back() = rates;
    } else {
      roc.push_back(rates);
    }
    last = kind;
  });
  verification.equal_error_rate = EqualErrorRate(roc);
  verification.d_prime = DPrime(scores);
  verification.area = AreaUnder(roc);
  return verification;
}

ScoreHistogram HistogramOf(const VerificationScores& scores, int bins) {
  double low = kInfinity;
  double high = -kInfinity;
  for (const std::vector<double>* values : {&scores.genuine, &scores.impostor}) {
    if (!values->empty()) {
      low = std::min(low, values->front());
      high = std::max(high, values->back());
    }
  }
  ScoreHistogram histogram;
  const int kept = low < high ? std::max(1, bins) : 1;
  histogram.first = std::isfinite(low) ? low : 0;
  histogram.width = low < high ? (high - low) / kept : 0;
  histogram.genuine = CountInBins(scores.genuine, histogram.first, histogram.width, kept);
  histogram.impostor = CountInBins(scores.impostor, histogram.first, histogram.width, kept);
  return histogram;
}

}  // namespace cohort
