// Which blobs the rows refer to.

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"

namespace cohort {
namespace {

using Visit = std::function<absl::Status(const Digest&)>;

constexpr int64_t kRowsPerPage = 1000;
constexpr size_t kDigestLength = 64;
constexpr int64_t kFirst = std::numeric_limits<int64_t>::min();

/// Every digest in the text of a row, wherever it stands: a field that a later build adds cannot
/// be forgotten here, and what looks like a digest and is none costs nothing.
absl::Status VisitDigests(const std::string& text, const Visit& visit) {
  constexpr char kHexDigits[] = "0123456789abcdef";
  size_t begin = text.find_first_of(kHexDigits);
  while (begin != std::string::npos) {
    const size_t end = std::min(text.find_first_not_of(kHexDigits, begin), text.size());
    if (end - begin == kDigestLength) {
      COHORT_ASSIGN_OR_RETURN(const Digest digest,
                              Digest::FromHex(std::string_view(text).substr(begin, kDigestLength)));
      COHORT_RETURN_IF_ERROR(visit(digest));
    }
    begin = text.find_first_of(kHexDigits, end);
  }
  return absl::OkStatus();
}

/// Walks a table in the order of its key (a, b), a page at a time.
/// @param select  of a, b and the text to search, without WHERE.
template <typename A, typename B>
absl::Status Walk(Database& database,
                  const std::string& select,
                  const std::string& key,
                  std::pair<A, B> after,
                  const Visit& visit) {
  const std::string query =
      select + " WHERE (" + key + ") > (:a, :b) ORDER BY " + key + " LIMIT :limit";
  std::vector<std::string> texts;
  do {
    texts.clear();
    COHORT_RETURN_IF_ERROR(database.Read([&](soci::session& sql) {
      const std::pair<A, B> begin = after;
      std::string text;
      soci::statement page = (sql.prepare << query, soci::use(begin.first), soci::use(begin.second),
                              soci::use(kRowsPerPage), soci::into(after.first),
                              soci::into(after.second), soci::into(text));
      page.execute();
      while (page.fetch()) {
        texts.push_back(text);
      }
      return absl::OkStatus();
    }));
    for (const std::string& text : texts) {
      COHORT_RETURN_IF_ERROR(VisitDigests(text, visit));
    }
  } while (static_cast<int64_t>(texts.size()) == kRowsPerPage);
  return absl::OkStatus();
}

}  // namespace

absl::Status Catalog::VisitBlobs(const Visit& visit) {
  using TwoTexts = std::pair<std::string, std::string>;
  using TextAndNumber = std::pair<std::string, int64_t>;
  using TwoNumbers = std::pair<int64_t, int64_t>;
  Database& database = *database_;
  // Rows before those they are made from: outputs of a job come from its tasks, results of tasks
  // and outcomes of meshes from what is remembered. So a row that comes meanwhile and is missed
  // names no old blob that a later table does not name.
  COHORT_RETURN_IF_ERROR(
      Walk(database, "SELECT set_name, name, raw FROM mesh", "set_name, name", TwoTexts(), visit));
  COHORT_RETURN_IF_ERROR(Walk(database, "SELECT number, number, spec || ' ' || outputs FROM job",
                              "number, number", TwoNumbers(kFirst, kFirst), visit));
  COHORT_RETURN_IF_ERROR(Walk(database, "SELECT job, idx, raw || ' ' || ingested FROM job_mesh",
                              "job, idx", TwoNumbers(kFirst, kFirst), visit));
  COHORT_RETURN_IF_ERROR(Walk(database, "SELECT job, number, result FROM task", "job, number",
                              TwoNumbers(kFirst, kFirst), visit));
  COHORT_RETURN_IF_ERROR(Walk(database, "SELECT raw, position_bits, result FROM ingested",
                              "raw, position_bits", TextAndNumber("", kFirst), visit));
  return Walk(database, "SELECT action_key, action_key, result FROM action",
              "action_key, action_key", TwoTexts(), visit);
}

}  // namespace cohort
