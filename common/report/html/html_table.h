#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cohort {

/// How the cells of a column are set.
enum class ColumnKind { kText, kNumber };

struct TableColumn {
  std::string title;  ///< Plain text.
  ColumnKind kind = ColumnKind::kText;
};

/// A table with headings and a caption; the first column heads the rows. Cells are HTML: escape
/// what comes from outside.
class HtmlTable {
 public:
  HtmlTable(std::string_view caption, std::vector<TableColumn> columns);
  /// @param cells  one per column.
  /// @param row_class  of the style sheet; empty: none.
  void AddRow(const std::vector<std::string>& cells, std::string_view row_class = {});
  [[nodiscard]] std::string Html() const;
  [[nodiscard]] int64_t RowCount() const { return rows_; }

 private:
  std::vector<TableColumn> columns_;
  std::string html_;
  int64_t rows_ = 0;
};

/// A part of the page that a heading opens.
/// @param id  for links; letters.
[[nodiscard]] std::string HtmlSection(std::string_view id,
                                      std::string_view title,
                                      std::string_view body);

/// What is wide or long, scrolled by itself on screen and whole on paper.
[[nodiscard]] std::string HtmlScroll(std::string_view name, std::string_view body);

/// A picture with its caption.
/// @param png  bytes.
[[nodiscard]] std::string HtmlPicture(std::string_view png,
                                      std::string_view description,
                                      std::string_view caption);

/// A paragraph; plain text.
[[nodiscard]] std::string HtmlHint(std::string_view text);

}  // namespace cohort
