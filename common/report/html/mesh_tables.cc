// Health of the files and registration: one row per mesh.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "common/report/decimal.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/job_meshes.h"
#include "common/report/markup.h"

namespace cohort {
namespace {

std::string Chips(const std::vector<std::string>& texts) {
  std::string html;
  for (const std::string& text : texts) {
    html += "<span class=\"chip\">" + EscapeMarkup(text) + "</span> ";
  }
  return html;
}

std::string Percent(double share) {
  return std::isnan(share) ? "-" : FixedDecimal(100 * share, 1) + " %";
}

// Rejected meshes first, then flagged ones, then the others; by name within each.
std::vector<size_t> FlaggedFirst(const ReportInput& input, const ReportAnalysis& analysis) {
  std::vector<size_t> order(input.meshes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto urgency = [&](size_t mesh) {
    if (!input.meshes[mesh].rejection.empty()) return 0;
    return analysis.flags[mesh].Any() ? 1 : 2;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return urgency(a) < urgency(b); });
  return order;
}

std::vector<std::string> LabelKeys(const ReportInput& input) {
  std::set<std::string> keys;
  for (const JobMesh& mesh : input.meshes) {
    for (const auto& [key, value] : mesh.mesh.labels) keys.insert(key);
  }
  return {keys.begin(), keys.end()};
}

std::string StatusChip(const JobMesh& mesh, const MeshFlags& flags) {
  if (!mesh.rejection.empty()) return "<span class=\"chip bad\">rejected</span>";
  return flags.Any() ? "<span class=\"chip\">look</span>" : "<span class=\"chip good\">ok</span>";
}

std::vector<std::string> HealthRow(const JobMesh& mesh,
                                   const MeshFlags& flags,
                                   const std::vector<std::string>& keys) {
  std::vector<std::string> cells = {EscapeMarkup(mesh.mesh.name), StatusChip(mesh, flags)};
  if (!mesh.rejection.empty()) {
    cells.push_back(EscapeMarkup(mesh.rejection));
  } else {
    cells.push_back(Chips(flags.file) + Chips(flags.registration) + Chips(flags.distances));
  }
  for (const std::string& key : keys) {
    const auto label = mesh.mesh.labels.find(key);
    cells.push_back(label == mesh.mesh.labels.end() ? "-" : EscapeMarkup(label->second));
  }
  if (mesh.ingested) {
    const MeshHealth& health = mesh.ingested->health;
    cells.push_back(std::to_string(mesh.ingested->vertices));
    cells.push_back(std::to_string(mesh.ingested->faces));
    cells.push_back(std::to_string(health.components));
    cells.push_back(Percent(health.boundary_share));
    cells.push_back(std::to_string(health.duplicate_vertices));
    cells.push_back(std::to_string(health.degenerate_faces + health.duplicate_faces));
    cells.push_back(std::to_string(health.non_manifold_edges));
    cells.push_back(ReadableDecimal(health.diagonal, 4));
  } else {
    cells.insert(cells.end(), 8, "-");
  }
  return cells;
}

std::string RowClass(const JobMesh& mesh, const MeshFlags& flags) {
  if (!mesh.rejection.empty()) return "rejected";
  return flags.Any() ? "flagged" : "";
}

// Row by row.
std::string RotationText(const Similarity& similarity) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      text += FixedDecimal(similarity.rotation(row, column), 4) + (column < 2 ? " " : "");
    }
    text += row < 2 ? "<br>" : "";
  }
  return text;
}

std::string TranslationText(const Similarity& similarity) {
  return FixedDecimal(similarity.translation.x(), 2) + " " +
         FixedDecimal(similarity.translation.y(), 2) + " " +
         FixedDecimal(similarity.translation.z(), 2);
}

}  // namespace

std::string HealthSection(const ReportInput& input, const ReportAnalysis& analysis) {
  const std::vector<std::string> keys = LabelKeys(input);
  std::vector<TableColumn> columns = {{"file"}, {"status"}, {"what to look at"}};
  for (const std::string& key : keys) columns.push_back({key});
  for (const char* title : {"vertices", "faces", "pieces", "border", "double vertices", "bad faces",
                            "non-manifold edges", "diagonal (mm)"}) {
    columns.push_back({title, ColumnKind::kNumber});
  }
  HtmlTable table(
      "Rejected and flagged files come first. Border: share of the edges with one face.",
      std::move(columns));
  for (const size_t mesh : FlaggedFirst(input, analysis)) {
    table.AddRow(HealthRow(input.meshes[mesh], analysis.flags[mesh], keys),
                 RowClass(input.meshes[mesh], analysis.flags[mesh]));
  }
  return HtmlSection("health", "Health of the files",
                     HtmlScroll("Health of the files", table.Html()));
}

std::string RegistrationSection(const ReportInput& input, const ReportAnalysis& analysis) {
  if (input.job.spec.method == Method::kNone) {
    return HtmlSection("registration", "Registration",
                       HtmlHint("Method none: the meshes were measured where they are."));
  }
  HtmlTable table(
      "To the reference: x_reference = scale R x_file + t; the same "
      "with all digits: transforms.csv.",
      {{"file"},
       {"residual (mm)", ColumnKind::kNumber},
       {"iterations", ColumnKind::kNumber},
       {"converged"},
       {"overlap", ColumnKind::kNumber},
       {"scale", ColumnKind::kNumber},
       {"R", ColumnKind::kNumber},
       {"t (mm)", ColumnKind::kNumber},
       {"flags"}});
  const std::vector<const MeshAlignment*> of_mesh = AlignmentOfEach(input);
  for (const size_t mesh : FlaggedFirst(input, analysis)) {
    if (of_mesh[mesh] == nullptr) continue;
    const Alignment& one = of_mesh[mesh]->alignment;
    const MeshFlags& flags = analysis.flags[mesh];
    table.AddRow(
        {EscapeMarkup(input.meshes[mesh].mesh.name), ReadableDecimal(one.rms_residual, 4),
         std::to_string(one.iterations), one.converged ? "yes" : "no", Percent(one.overlap),
         FixedDecimal(one.T_target_source.scale, 5), RotationText(one.T_target_source),
         TranslationText(one.T_target_source), Chips(flags.registration)},
        flags.registration.empty() ? "" : "flagged");
  }
  const std::string each = input.job.spec.method == Method::kEach
                               ? HtmlHint(
                                     "Method each: every pair was aligned by itself; these are "
                                     "the alignments to the base mesh.")
                               : "";
  return HtmlSection("registration", "Registration",
                     each + HtmlScroll("Registration", table.Html()));
}

}  // namespace cohort
