#pragma once

#include <span>
#include <string_view>

namespace cohort {

/// Statements that take the schema one version further.
using Migration = std::span<const std::string_view>;

/// Element i takes a catalog of version i to version i + 1; version 0 is an empty database. Only
/// ever appended to: catalogs of every version are out there.
///
/// Standard SQL with TEXT and BIGINT columns, JSON as TEXT, no NULLs (the empty text is "none").
/// Names are compared bytewise: SQLite's default; a PostgreSQL database is to be created with
/// LC_COLLATE 'C'.
[[nodiscard]] std::span<const Migration> SchemaMigrations();

}  // namespace cohort
