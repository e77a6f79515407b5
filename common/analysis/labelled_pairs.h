#pragma once

#include <cstdint>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/identification.h"

namespace cohort {

/// What is known of the persons of a pair of meshes.
enum class PairKind {
  kGenuine,      ///< One person.
  kImpostor,     ///< Two persons.
  kUnknown,      ///< A person or session is not known, or a mesh with itself.
  kSameSession,  ///< Left out under Gallery::kOtherSessions.
};

/// Who is whom, by number instead of by name. Const calls may run together.
class LabelledPairs {
 public:
  /// @return kInvalidArgument if the labels are not one per row, under two persons are known, or
  ///         under two sessions for kOtherSessions.
  [[nodiscard]] static absl::StatusOr<LabelledPairs> Create(int64_t count,
                                                            const Identities& identities,
                                                            Gallery gallery);

  [[nodiscard]] PairKind KindOf(int64_t a, int64_t b) const;
  /// Whether all that is needed of the mesh is known.
  [[nodiscard]] bool TakesPart(int64_t mesh) const {
    return persons_[static_cast<size_t>(mesh)] >= 0 && sessions_[static_cast<size_t>(mesh)] >= 0;
  }
  [[nodiscard]] int64_t Count() const { return static_cast<int64_t>(persons_.size()); }

 private:
  LabelledPairs() = default;

  std::vector<int64_t> persons_;   ///< -1: unknown.
  std::vector<int64_t> sessions_;  ///< -1: unknown; all 0 if sessions do not matter.
  bool by_session_ = false;
};

}  // namespace cohort
