#include "common/analysis/labelled_pairs.h"

#include <map>
#include <span>
#include <string>
#include <string_view>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

absl::StatusOr<std::vector<int64_t>> Numbered(std::span<const std::string> labels,
                                              int64_t count,
                                              std::string_view what) {
  if (std::ssize(labels) != count) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", labels.size(), " labels of ",
                                                   std::string(what), " for ", count, " meshes"));
  }
  std::map<std::string_view, int64_t> numbers;
  std::vector<int64_t> numbered;
  numbered.reserve(labels.size());
  for (const std::string& label : labels) {
    numbered.push_back(label.empty() ? -1 : numbers.emplace(label, numbers.size()).first->second);
  }
  if (numbers.size() < 2) {
    return absl::InvalidArgumentError(
        numbers.empty() ? absl::StrCat("no mesh has a ", std::string(what))
                        : absl::StrCat("all meshes have the same ", std::string(what), ", ",
                                       std::string(numbers.begin()->first)));
  }
  return numbered;
}

}  // namespace

absl::StatusOr<LabelledPairs> LabelledPairs::Create(int64_t count,
                                                    const Identities& identities,
                                                    Gallery gallery) {
  LabelledPairs pairs;
  COHORT_ASSIGN_OR_RETURN(pairs.persons_, Numbered(identities.persons, count, "person"));
  pairs.by_session_ = gallery == Gallery::kOtherSessions;
  pairs.sessions_.assign(static_cast<size_t>(count), 0);
  if (pairs.by_session_) {
    COHORT_ASSIGN_OR_RETURN(pairs.sessions_, Numbered(identities.sessions, count, "session"));
  }
  return pairs;
}

PairKind LabelledPairs::KindOf(int64_t a, int64_t b) const {
  if (a == b || !TakesPart(a) || !TakesPart(b)) {
    return PairKind::kUnknown;
  }
  const auto i = static_cast<size_t>(a);
  const auto j = static_cast<size_t>(b);
  if (by_session_ && sessions_[i] == sessions_[j]) {
    return PairKind::kSameSession;
  }
  return persons_[i] == persons_[j] ? PairKind::kGenuine : PairKind::kImpostor;
}

}  // namespace cohort
