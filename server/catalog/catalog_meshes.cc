// Sets, their meshes, and what ingest made of raw files.

#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"
#include "server/catalog/ingested_rows.h"
#include "server/catalog/page_token.h"
#include "server/catalog/row_json.h"

namespace cohort {
namespace {

std::vector<MeshSet> SelectSets(soci::session& sql, const std::string& after, int64_t limit) {
  MeshSet set;
  soci::statement select =
      (sql.prepare << "SELECT set_name, COUNT(*), CAST(SUM(size_bytes) AS BIGINT) FROM mesh "
                      "WHERE set_name > :after GROUP BY set_name ORDER BY set_name LIMIT :limit",
       soci::use(after), soci::use(limit), soci::into(set.name), soci::into(set.meshes),
       soci::into(set.size_bytes));
  select.execute();
  std::vector<MeshSet> sets;
  while (select.fetch()) {
    sets.push_back(set);
  }
  return sets;
}

absl::StatusOr<std::vector<SetMesh>> SelectMeshes(soci::session& sql,
                                                  const std::string& set,
                                                  const std::string& after,
                                                  int64_t limit) {
  SetMesh mesh;
  std::string raw;
  std::string labels;
  soci::statement select =
      (sql.prepare << "SELECT name, raw, size_bytes, labels FROM mesh "
                      "WHERE set_name = :set_name AND name > :after ORDER BY name LIMIT :limit",
       soci::use(set), soci::use(after), soci::use(limit), soci::into(mesh.name), soci::into(raw),
       soci::into(mesh.size_bytes), soci::into(labels));
  select.execute();
  std::vector<SetMesh> meshes;
  while (select.fetch()) {
    COHORT_ASSIGN_OR_RETURN(mesh.raw, DigestFromText(raw));
    COHORT_ASSIGN_OR_RETURN(mesh.labels, LabelsFromText(labels));
    meshes.push_back(mesh);
  }
  return meshes;
}

/// Cuts a listing that was asked for one item too many: the item tells that there is another page.
template <typename T>
void CutToPage(Listing listing, int page_size, Page<T>& page) {
  if (page.items.size() > static_cast<size_t>(page_size)) {
    page.items.pop_back();
    page.next_token = MakePageToken(listing, page.items.back().name);
  }
}

}  // namespace

IngestedWriter::IngestedWriter(soci::session& sql)
    : upsert_(
          (sql.prepare << "INSERT INTO ingested (raw, position_bits, result) "
                          "VALUES (:raw, :position_bits, :result) "
                          "ON CONFLICT (raw, position_bits) DO UPDATE SET result = excluded.result",
           soci::use(raw_),
           soci::use(position_bits_),
           soci::use(result_))) {}

void IngestedWriter::Write(const Digest& raw, int position_bits, const IngestedMesh& mesh) {
  raw_ = raw.Hex();
  position_bits_ = position_bits;
  result_ = IngestedToText(mesh);
  upsert_.execute(true);
}

absl::Status Catalog::AddMesh(const std::string& set, const SetMesh& mesh) {
  if (set.empty() || mesh.name.empty()) {
    return absl::InvalidArgumentError("a set and a mesh need a name: set '" + set + "', mesh '" +
                                      mesh.name + "'");
  }
  return database_->Write([&](soci::session& sql) -> absl::Status {
    const std::string raw = mesh.raw.Hex();
    const std::string labels = LabelsToText(mesh.labels);
    soci::statement upsert =
        (sql.prepare << "INSERT INTO mesh (set_name, name, raw, size_bytes, labels) "
                        "VALUES (:set_name, :name, :raw, :size_bytes, :labels) "
                        "ON CONFLICT (set_name, name) DO UPDATE SET labels = excluded.labels "
                        "WHERE mesh.raw = excluded.raw",
         soci::use(set), soci::use(mesh.name), soci::use(raw), soci::use(mesh.size_bytes),
         soci::use(labels));
    upsert.execute(true);
    if (upsert.get_affected_rows() == 0) {
      return absl::AlreadyExistsError("set '" + set + "' has other bytes under the name '" +
                                      mesh.name + "'");
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<Page<MeshSet>> Catalog::ListSets(int page_size, const std::string& token) {
  COHORT_RETURN_IF_ERROR(CheckPageSize(page_size));
  COHORT_ASSIGN_OR_RETURN(const std::string after, ReadPageToken(Listing::kSets, token));
  Page<MeshSet> page;
  COHORT_RETURN_IF_ERROR(database_->Read([&](soci::session& sql) {
    page.items = SelectSets(sql, after, int64_t{page_size} + 1);
    return absl::OkStatus();
  }));
  CutToPage(Listing::kSets, page_size, page);
  return page;
}

absl::StatusOr<Page<SetMesh>> Catalog::ListMeshes(const std::string& set,
                                                  int page_size,
                                                  const std::string& token) {
  COHORT_RETURN_IF_ERROR(CheckPageSize(page_size));
  COHORT_ASSIGN_OR_RETURN(const std::string after, ReadPageToken(Listing::kMeshes, token));
  Page<SetMesh> page;
  COHORT_ASSIGN_OR_RETURN(page.items,
                          database_->ReadValue<std::vector<SetMesh>>([&](soci::session& sql) {
                            return SelectMeshes(sql, set, after, int64_t{page_size} + 1);
                          }));
  if (page.items.empty() && token.empty()) {
    return absl::NotFoundError("there is no set '" + set + "'");
  }
  CutToPage(Listing::kMeshes, page_size, page);
  return page;
}

absl::StatusOr<std::optional<IngestedMesh>> Catalog::FindIngested(const Digest& raw,
                                                                  int position_bits) {
  using Found = std::optional<IngestedMesh>;
  return database_->ReadValue<Found>([&](soci::session& sql) -> absl::StatusOr<Found> {
    std::string result;
    sql << "SELECT result FROM ingested WHERE raw = :raw AND position_bits = :position_bits",
        soci::use(raw.Hex()), soci::use(position_bits), soci::into(result);
    if (!sql.got_data()) {
      return std::nullopt;
    }
    return IngestedFromText(result);
  });
}

absl::Status Catalog::RecordIngested(const Digest& raw,
                                     int position_bits,
                                     const IngestedMesh& mesh) {
  return database_->Write([&](CatalogSession& sql) {
    sql.Kept<IngestedWriter>().Write(raw, position_bits, mesh);
    return absl::OkStatus();
  });
}

}  // namespace cohort
