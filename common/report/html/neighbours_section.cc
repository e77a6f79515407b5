#include <algorithm>

#include "common/report/decimal.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/markup.h"

namespace cohort {
namespace {

constexpr size_t kMostShown = 5;      // Neighbours of a mesh.
constexpr size_t kMostMeshes = 2000;  // Rows of the table.

std::string Picture(const ReportInput& input, size_t row) {
  if (row >= input.thumbnails.size() || input.thumbnails[row].empty()) return "";
  return "<span class=\"thumb t" + std::to_string(row) + "\" role=\"img\" aria-label=\"" +
         EscapeMarkup(input.matrix.labels[row]) + "\"></span>";
}

std::string PersonText(const ReportInput& input, size_t row) {
  if (input.persons[row].empty()) return "";
  return "<br><span class=\"hint\">" + EscapeMarkup(input.persons[row]) + "</span>";
}

std::string NeighbourCell(const ReportInput& input, size_t row, const Neighbour& neighbour) {
  const auto column = static_cast<size_t>(neighbour.column);
  const bool same = !input.persons[row].empty() && input.persons[row] == input.persons[column];
  return Picture(input, column) + "<span class=\"value\">" +
         WithUnit(ReadableDecimal(neighbour.value, 3), input.description) + "</span>" +
         (same ? " <span class=\"chip good\">same person</span>" : "") + "<br>" +
         EscapeMarkup(input.matrix.labels[column]) + PersonText(input, column);
}

}  // namespace

std::string ThumbnailStyle(const ReportInput& input) {
  std::string style;
  for (size_t row = 0; row < input.thumbnails.size(); ++row) {
    if (input.thumbnails[row].empty()) continue;
    style += ".t" + std::to_string(row) + "{background-image:url(data:image/png;base64," +
             Base64(input.thumbnails[row]) + ")}\n";
  }
  return style;
}

std::string NeighboursSection(const ReportInput& input) {
  if (input.neighbours.empty()) {
    return HtmlSection("neighbours", "Most similar meshes",
                       HtmlHint("Left out: of signed distances the smallest is not the most "
                                "similar."));
  }
  size_t shown = 0;
  for (const auto& list : input.neighbours) {
    shown = std::max(shown, std::min(list.size(), kMostShown));
  }
  if (shown == 0) return "";
  std::vector<TableColumn> columns = {{"mesh"}};
  for (size_t k = 1; k <= shown; ++k) columns.push_back({std::to_string(k) + "."});
  HtmlTable table("", std::move(columns));
  const size_t rows = std::min(input.neighbours.size(), kMostMeshes);
  for (size_t row = 0; row < rows; ++row) {
    std::vector<std::string> cells = {Picture(input, row) + EscapeMarkup(input.matrix.labels[row]) +
                                      PersonText(input, row)};
    for (size_t k = 0; k < shown; ++k) {
      cells.push_back(k < input.neighbours[row].size()
                          ? NeighbourCell(input, row, input.neighbours[row][k])
                          : "-");
    }
    table.AddRow(cells);
  }
  std::string body;
  if (!input.thumbnails_note.empty()) body += HtmlHint(input.thumbnails_note);
  if (rows < input.neighbours.size()) {
    body += HtmlHint("The first " + std::to_string(rows) + " of " +
                     std::to_string(input.neighbours.size()) +
                     " meshes; neighbours.csv has all of them.");
  }
  return HtmlSection("neighbours", "Most similar meshes",
                     body + HtmlScroll("Most similar meshes", table.Html()));
}

}  // namespace cohort
