#include "server/catalog/schema.h"

#include <array>

namespace cohort {
namespace {

constexpr std::array<std::string_view, 8> kVersion1 = {
    // Numbers given out. Not the highest number in a table: what is deleted is never named again.
    R"(CREATE TABLE counter (
         name TEXT NOT NULL PRIMARY KEY,
         value BIGINT NOT NULL))",
    R"(CREATE TABLE mesh (
         set_name TEXT NOT NULL,
         name TEXT NOT NULL,
         raw TEXT NOT NULL,
         size_bytes BIGINT NOT NULL,
         labels TEXT NOT NULL,
         PRIMARY KEY (set_name, name)))",
    R"(CREATE TABLE ingested (
         raw TEXT NOT NULL,
         position_bits BIGINT NOT NULL,
         result TEXT NOT NULL,
         PRIMARY KEY (raw, position_bits)))",
    R"(CREATE TABLE job (
         number BIGINT NOT NULL PRIMARY KEY,
         request_id TEXT NOT NULL,
         set_name TEXT NOT NULL,
         spec TEXT NOT NULL,
         state TEXT NOT NULL,
         error TEXT NOT NULL,
         version BIGINT NOT NULL,
         created_unix_ms BIGINT NOT NULL,
         started_unix_ms BIGINT NOT NULL,
         finished_unix_ms BIGINT NOT NULL,
         meshes BIGINT NOT NULL,
         rejected_meshes BIGINT NOT NULL,
         progress TEXT NOT NULL,
         counters TEXT NOT NULL,
         outputs TEXT NOT NULL))",
    "CREATE UNIQUE INDEX job_by_request ON job (request_id) WHERE request_id <> ''",
    "CREATE INDEX job_by_state ON job (state, number)",
    // The meshes as they were when the job was created, and what became of each.
    R"(CREATE TABLE job_mesh (
         job BIGINT NOT NULL REFERENCES job (number),
         idx BIGINT NOT NULL,
         name TEXT NOT NULL,
         raw TEXT NOT NULL,
         size_bytes BIGINT NOT NULL,
         labels TEXT NOT NULL,
         ingested TEXT NOT NULL,
         rejection TEXT NOT NULL,
         PRIMARY KEY (job, idx)))",
    R"(CREATE TABLE task (
         job BIGINT NOT NULL REFERENCES job (number),
         number BIGINT NOT NULL,
         epoch BIGINT NOT NULL,
         failures BIGINT NOT NULL,
         losses BIGINT NOT NULL,
         worker TEXT NOT NULL,
         result TEXT NOT NULL,
         last_error TEXT NOT NULL,
         PRIMARY KEY (job, number)))",
};

constexpr std::array<std::string_view, 2> kVersion2 = {
    // Finished tasks by action key: what is known is not computed again.
    R"(CREATE TABLE action (
         action_key TEXT NOT NULL PRIMARY KEY,
         result TEXT NOT NULL,
         created_unix_ms BIGINT NOT NULL))",
    "CREATE INDEX action_by_time ON action (created_unix_ms)",
};

constexpr std::array<std::string_view, 1> kVersion3 = {
    "ALTER TABLE task ADD COLUMN given_up BIGINT NOT NULL DEFAULT 0",
};

constexpr std::array<std::string_view, 2> kVersion4 = {
    "ALTER TABLE job ADD COLUMN plan_version BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE job ADD COLUMN results_version BIGINT NOT NULL DEFAULT 0",
};

constexpr std::array<Migration, 4> kMigrations = {Migration(kVersion1), Migration(kVersion2),
                                                  Migration(kVersion3), Migration(kVersion4)};

}  // namespace

std::span<const Migration> SchemaMigrations() {
  return kMigrations;
}

}  // namespace cohort
