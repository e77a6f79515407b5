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
/// Texts are compared bytewise: SQLite's default; PostgreSQL is told so with each column (" TEXT "
/// becomes " TEXT COLLATE "C" ", DatabaseBackend::Ddl).
[[nodiscard]] std::span<const Migration> SchemaMigrations();

}  // namespace cohort
