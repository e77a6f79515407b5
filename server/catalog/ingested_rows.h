#pragma once

#include <utility>
#include <vector>

#include <absl/status/status.h>

#include "common/jobs/task.h"
#include "server/catalog/soci_sqlite.h"

namespace cohort {

/// Writes rows of the table ingested, over what is there: ingest is pure. Only for bodies of
/// Database: throws what SOCI throws.
void UpsertIngested(soci::session& sql,
                    int position_bits,
                    const std::vector<std::pair<Digest, IngestedMesh>>& meshes);

}  // namespace cohort
