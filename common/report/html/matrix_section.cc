// The heat map: the matrix in few bytes for report.js.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include <nlohmann/json.hpp>

#include "common/base/utf8.h"
#include "common/report/canvas.h"
#include "common/report/color_map.h"
#include "common/report/decimal.h"
#include "common/report/heatmap.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/markup.h"
#include "common/report/matrix_picture.h"
#include "common/report/plot_text.h"

namespace cohort {
namespace {

constexpr int64_t kMostPrecise = 1000;  // Meshes whose cells have 16 bits; more have 8.
constexpr int64_t kMostDrawn = 3000;    // More are a picture without names.
constexpr int64_t kMostNamed = 68;      // More rows than this are lower than 9 pixels (report.js).
constexpr double kNameWidth = 180;      // Pixels.
constexpr int kShades = 256;

// A matrix as codes: 0 for no value, 1..largest from low to high.
struct CodedMatrix {
  double low = 0;
  double high = 1;
  int bits = 16;
  std::string bytes;

  [[nodiscard]] int Largest() const { return bits == 16 ? 65535 : 255; }
  // Largest difference between a value and what its code says.
  [[nodiscard]] double Error() const { return (high - low) / (Largest() - 1) / 2; }
  void Add(double value) {
    int code = 0;
    if (!std::isnan(value)) {
      const double place = high > low ? (value - low) / (high - low) : 0;
      code = 1 + static_cast<int>(std::lround(place * (Largest() - 1)));
    }
    bytes += static_cast<char>(static_cast<uint8_t>(code & 255));
    if (bits == 16) bytes += static_cast<char>(static_cast<uint8_t>(code >> 8));
  }
};

CodedMatrix Encode(const Eigen::Ref<const RowMajorMatrix>& values,
                   const MatrixPicture& picture,
                   int bits,
                   Symmetrization pairs) {
  CodedMatrix coded{picture.smallest, picture.largest, bits, {}};
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    const Eigen::Index end = pairs == Symmetrization::kDirected ? values.cols() : row;
    for (Eigen::Index column = 0; column < end; ++column) {
      coded.Add(row == column ? std::nan("") : values(row, column));
    }
  }
  return coded;
}

// Mesh numbers in the order of the tree; those that are not in it at the end.
std::vector<int64_t> ClusterOrder(const ReportAnalysis& analysis, int64_t count) {
  if (!analysis.tree) return {};
  std::vector<int64_t> order;
  std::vector<bool> is_in(static_cast<size_t>(count), false);
  for (const int64_t leaf : analysis.tree->leaf_order) {
    order.push_back(analysis.rows[static_cast<size_t>(leaf)]);
    is_in[static_cast<size_t>(order.back())] = true;
  }
  for (int64_t mesh = 0; mesh < count; ++mesh) {
    if (!is_in[static_cast<size_t>(mesh)]) order.push_back(mesh);
  }
  return order;
}

std::vector<int> Shades() {
  std::vector<int> channels;
  for (int i = 0; i < kShades; ++i) {
    const Rgb color = MapColor(i / (kShades - 1.0));
    channels.insert(channels.end(), {color.red, color.green, color.blue});
  }
  return channels;
}

// As an element that scripts can read and that no text can end: "<" is written as an escape.
std::string JsonElement(const nlohmann::json& json) {
  std::string html = "<script type=\"application/json\" id=\"matrix-data\">";
  for (const char c : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    html += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return html + "</script>\n";
}

std::vector<std::string> Printable(std::span<const std::string> texts) {
  std::vector<std::string> printable;
  for (const std::string& text : texts) printable.push_back(PrintableUtf8(text));
  return printable;
}

// Names that fit beside the rows; none if the rows are too low for a name.
std::vector<std::string> ShortNames(std::span<const std::string> labels) {
  if (std::ssize(labels) > kMostNamed) return {};
  return FittedLabels(labels, kNameWidth,
                      [](const std::string& text) { return TextWidth(text, {.size = 13}); });
}

// The colours with their ends, as a style so that it also prints without the script.
std::string ColorBar(const MatrixPicture& picture, const MatrixDescription& description) {
  std::string stops;
  for (int i = 0; i <= 16; ++i) {
    const Rgb color = MapColor(i / 16.0);
    stops += (i == 0 ? "rgb(" : ",rgb(") + std::to_string(color.red) + "," +
             std::to_string(color.green) + "," + std::to_string(color.blue) + ")";
  }
  const std::string beyond = picture.clipped_high ? " and more" : "";
  return "<div class=\"bar\" style=\"background:linear-gradient(to right," + stops +
         ")\"></div>\n<div class=\"bar-ends\"><span>" + ReadableDecimal(picture.range.low, 3) +
         "</span><span>" + EscapeMarkup(ValueTitle(description)) + "</span><span>" +
         ReadableDecimal(picture.range.high, 3) + beyond + "</span></div>\n";
}

std::string Controls(const ReportInput& input, const ReportAnalysis& analysis) {
  std::string html =
      "<label for=\"map-sort\">Order of rows and columns<select id=\"map-sort\">"
      "<option value=\"name\">by file name</option>";
  if (analysis.tree) html += "<option value=\"clusters\">by clusters (dendrogram below)</option>";
  const bool has_persons = std::any_of(input.persons.begin(), input.persons.end(),
                                       [](const std::string& person) { return !person.empty(); });
  if (has_persons) html += "<option value=\"person\">by person</option>";
  return html +
         "<option value=\"mesh\">by distance to one mesh</option></select></label>\n"
         "<label for=\"map-mesh\" hidden>Mesh<select id=\"map-mesh\"></select></label>\n";
}

std::string Drawn(const ReportInput& input, const ReportAnalysis& analysis) {
  const auto count = static_cast<int64_t>(input.matrix.labels.size());
  const MatrixPicture picture = MakeMatrixPicture(input.matrix.values, static_cast<int>(count));
  const Symmetrization pairs = input.description.symmetrization;
  const CodedMatrix coded =
      Encode(input.matrix.values, picture, count > kMostPrecise ? 8 : 16, pairs);
  const std::string unit = ValueUnit(input.description);
  const nlohmann::json json = {{"names", Printable(input.matrix.labels)},
                               {"short_names", ShortNames(input.matrix.labels)},
                               {"persons", Printable(input.persons)},
                               {"clusters", ClusterOrder(analysis, count)},
                               {"symmetric", pairs != Symmetrization::kDirected},
                               {"bits", coded.bits},
                               {"low", coded.low},
                               {"high", coded.high},
                               {"color_low", picture.range.low},
                               {"color_high", picture.range.high},
                               {"unit", unit},
                               {"colors", Shades()},
                               {"cells", Base64(coded.bytes)}};
  std::string html =
      "<div class=\"map\"><div class=\"map-frame\"><canvas id=\"map\" role=\"img\" tabindex=\"0\" "
      "aria-label=\"Heat map: " +
      EscapeMarkup(ValueTitle(input.description)) + " of all pairs of " + std::to_string(count) +
      " meshes; arrow keys move from pair to pair\">heatmap.png beside this file shows the same."
      "</canvas><div id=\"map-mark\"></div></div>\n<div class=\"map-side\">\n" +
      Controls(input, analysis) +
      "<output id=\"map-said\" aria-live=\"polite\"><span class=\"hint screen\">Point at a cell to "
      "see its pair; click it to sort by the distance to its column's mesh.</span></output>\n" +
      ColorBar(picture, input.description);
  html += HtmlHint(std::string("Columns are in the order of the rows. Grey cells have no value. "
                               "Values under the pointer are to within ") +
                   WithUnit(ReadableDecimal(coded.Error(), 2), input.description) +
                   (coded.bits == 8 ? " (reduced, since there are many meshes)" : "") +
                   "; matrix.csv has all digits.");
  return html + "</div></div>\n<noscript>" +
         HtmlHint("Scripts are off: see heatmap.png beside this file.") + "</noscript>\n" +
         JsonElement(json);
}

}  // namespace

std::string MatrixSection(const ReportInput& input, const ReportAnalysis& analysis) {
  const auto count = static_cast<int64_t>(input.matrix.labels.size());
  if (count < 2) {
    return HtmlSection("matrix", "Matrix", HtmlHint("One mesh has no pair to show."));
  }
  if (count <= kMostDrawn) {
    return HtmlSection("matrix", "Matrix", Drawn(input, analysis));
  }
  const absl::StatusOr<std::string> png = HeatmapPng(input.matrix, input.description);
  const std::string hint =
      HtmlHint("More than " + std::to_string(kMostDrawn) +
               " meshes: a picture of block means; matrix.csv has every pair.");
  return HtmlSection("matrix", "Matrix",
                     hint + (png.ok() ? HtmlPicture(*png, "Heat map of all pairs", "")
                                      : HtmlHint(std::string(png.status().message()))));
}

}  // namespace cohort
