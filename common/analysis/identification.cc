#include "common/analysis/identification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/analysis/labelled_pairs.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

ProbeSearch Search(const MetricMatrix& matrix, const LabelledPairs& pairs, int64_t probe) {
  ProbeSearch search{.probe = probe,
                     .mate_value = std::numeric_limits<double>::quiet_NaN(),
                     .impostor_value = std::numeric_limits<double>::quiet_NaN()};
  for (int64_t other = 0; other < matrix.values.cols(); ++other) {
    const double value = matrix.values(probe, other);
    const PairKind kind = pairs.KindOf(probe, other);
    if (std::isnan(value)) {
      continue;
    }
    if (kind == PairKind::kGenuine && !(value >= search.mate_value)) {
      search.mate = other;
      search.mate_value = value;
    } else if (kind == PairKind::kImpostor && !(value >= search.impostor_value)) {
      search.impostor = other;
      search.impostor_value = value;
    }
  }
  return search;
}

/// 1 + the meshes of others that come before the mate.
int64_t RankOfMate(const MetricMatrix& matrix,
                   const LabelledPairs& pairs,
                   const ProbeSearch& search) {
  int64_t rank = 1;
  for (int64_t other = 0; other < matrix.values.cols(); ++other) {
    if (pairs.KindOf(search.probe, other) == PairKind::kImpostor &&
        matrix.values(search.probe, other) <= search.mate_value) {
      ++rank;
    }
  }
  return rank;
}

/// The most meshes of others that a search has to do with, and the mate itself.
int64_t LargestGallery(const LabelledPairs& pairs, const Identification& identification) {
  int64_t largest = 0;
  for (const ProbeSearch& search : identification.searches) {
    if (search.rank > 0) {
      int64_t others = 0;
      for (int64_t other = 0; other < pairs.Count(); ++other) {
        others += pairs.KindOf(search.probe, other) == PairKind::kImpostor ? 1 : 0;
      }
      largest = std::max(largest, others + 1);
    }
  }
  return largest;
}

}  // namespace

double Identification::ShareAtRank(int64_t k) const {
  return k <= std::ssize(match_share) ? match_share[static_cast<size_t>(k - 1)] : 1;
}

absl::StatusOr<Identification> IdentifyPersons(const MetricMatrix& matrix,
                                               const Identities& identities,
                                               Gallery gallery) {
  COHORT_RETURN_IF_ERROR(RequireDissimilarities(matrix, 2));
  COHORT_ASSIGN_OR_RETURN(const LabelledPairs pairs,
                          LabelledPairs::Create(matrix.values.rows(), identities, gallery));
  Identification identification;
  for (int64_t probe = 0; probe < matrix.values.rows(); ++probe) {
    if (!pairs.TakesPart(probe)) {
      continue;
    }
    ProbeSearch search = Search(matrix, pairs, probe);
    if (search.mate >= 0) {
      search.rank = RankOfMate(matrix, pairs, search);
      ++identification.with_mate;
    }
    identification.searches.push_back(search);
  }
  std::vector<int64_t> found(static_cast<size_t>(LargestGallery(pairs, identification)) + 1);
  for (const ProbeSearch& search : identification.searches) {
    ++found[static_cast<size_t>(search.rank)];
  }
  int64_t so_far = 0;
  for (size_t rank = 1; rank < found.size(); ++rank) {
    so_far += found[rank];
    identification.match_share.push_back(static_cast<double>(so_far) /
                                         static_cast<double>(identification.with_mate));
  }
  return identification;
}

}  // namespace cohort
