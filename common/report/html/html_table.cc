#include "common/report/html/html_table.h"

#include <cassert>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/report/markup.h"

namespace cohort {
namespace {

std::string CellTag(std::string_view tag, const TableColumn& column, std::string_view scope) {
  std::string html = absl::StrCat("<", std::string(tag));
  if (!scope.empty()) absl::StrAppend(&html, " scope=\"", std::string(scope), "\"");
  if (column.kind == ColumnKind::kNumber) html += " class=\"number\"";
  return html + ">";
}

}  // namespace

HtmlTable::HtmlTable(std::string_view caption, std::vector<TableColumn> columns)
    : columns_(std::move(columns)) {
  html_ = "<table>\n";
  if (!caption.empty()) html_ += "<caption>" + EscapeMarkup(caption) + "</caption>\n";
  html_ += "<thead><tr>";
  for (const TableColumn& column : columns_) {
    html_ += CellTag("th", column, "col") + EscapeMarkup(column.title) + "</th>";
  }
  html_ += "</tr></thead>\n<tbody>\n";
}

void HtmlTable::AddRow(const std::vector<std::string>& cells, std::string_view row_class) {
  assert(cells.size() == columns_.size());
  html_ += row_class.empty() ? "<tr>" : absl::StrCat("<tr class=\"", std::string(row_class), "\">");
  for (size_t i = 0; i < cells.size(); ++i) {
    const std::string tag = i == 0 ? "th" : "td";
    html_ += CellTag(tag, columns_[i], i == 0 ? "row" : "");
    absl::StrAppend(&html_, cells[i], "</", tag, ">");
  }
  html_ += "</tr>\n";
  ++rows_;
}

std::string HtmlTable::Html() const {
  return html_ + "</tbody>\n</table>\n";
}

std::string HtmlSection(std::string_view id, std::string_view title, std::string_view body) {
  return "<section id=\"" + std::string(id) + "\">\n<h2>" + EscapeMarkup(title) + "</h2>\n" +
         std::string(body) + "</section>\n";
}

std::string HtmlScroll(std::string_view name, std::string_view body) {
  return "<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"" + EscapeMarkup(name) +
         "\">\n" + std::string(body) + "</div>\n";
}

std::string HtmlPicture(std::string_view png,
                        std::string_view description,
                        std::string_view caption) {
  return "<figure>\n<img alt=\"" + EscapeMarkup(description) + "\" src=\"data:image/png;base64," +
         Base64(png) + "\">\n<figcaption>" + EscapeMarkup(caption) + "</figcaption>\n</figure>\n";
}

std::string HtmlHint(std::string_view text) {
  return "<p class=\"hint\">" + EscapeMarkup(text) + "</p>\n";
}

}  // namespace cohort
