#pragma once

#include <string>

#include "common/jobs/task.h"
#include "server/catalog/soci_session.h"

namespace cohort {

/// Writes rows of the table ingested, over what is there: ingest is pure. One that a session keeps.
/// Only for bodies of Database: throws what SOCI throws. Not thread-safe.
class IngestedWriter {
 public:
  explicit IngestedWriter(soci::session& sql);
  void Write(const Digest& raw, int position_bits, const IngestedMesh& mesh);

 private:
  std::string raw_;
  int position_bits_ = 0;
  std::string result_;
  soci::statement upsert_;
};

}  // namespace cohort
