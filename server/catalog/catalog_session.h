#pragma once

#include <map>
#include <memory>
#include <typeindex>

#include "server/catalog/soci_session.h"

namespace cohort {

/// The session of a Database, with statements that stay prepared: SQLite and PostgreSQL take longer
/// to prepare one of ours than to run it. Not thread-safe.
class CatalogSession : public soci::session {
 public:
  /// The one T of this session, made by T(*this) when it is first asked for. Its statements must
  /// have been run to their end whenever a body is left: one that is not holds a lock.
  template <typename T>
  [[nodiscard]] T& Kept() {
    std::shared_ptr<void>& kept = kept_[std::type_index(typeid(T))];
    if (kept == nullptr) {
      kept = std::make_shared<T>(*this);
    }
    return *static_cast<T*>(kept.get());
  }
  /// Needed before the session is closed, and after an error: SOCI leaves a statement that failed
  /// unusable.
  void Forget() { kept_.clear(); }

 private:
  std::map<std::type_index, std::shared_ptr<void>> kept_;
};

}  // namespace cohort
