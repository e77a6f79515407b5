#include "server/catalog/catalog.h"

#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/database.h"

namespace cohort {

absl::StatusOr<std::unique_ptr<Catalog>> Catalog::Open(const std::string& location) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<Database> database, Database::Open(location));
  return std::unique_ptr<Catalog>(new Catalog(std::move(database)));
}

Catalog::Catalog(std::unique_ptr<Database> database) : database_(std::move(database)) {}

Catalog::~Catalog() = default;

CallTimes Catalog::WriteTimes() const {
  return database_->WriteTimes();
}

}  // namespace cohort
