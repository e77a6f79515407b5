#include "common/report/html/report_html.h"

#include <charconv>
#include <cstdint>

#include "common/base/sha256.h"
#include "common/base/status_macros.h"
#include "common/report/html/embedded_files.h"
#include "common/report/html/sections.h"
#include "common/report/markup.h"

namespace cohort {
namespace {

absl::Status CheckSizes(const ReportInput& input) {
  const auto count = static_cast<Eigen::Index>(input.matrix.labels.size());
  const bool holds = input.matrix.values.rows() == count && input.matrix.values.cols() == count &&
                     std::ssize(input.persons) == count &&
                     (input.neighbours.empty() || std::ssize(input.neighbours) == count) &&
                     (input.thumbnails.empty() || std::ssize(input.thumbnails) == count);
  if (holds) return absl::OkStatus();
  return absl::InvalidArgumentError("report: " + std::to_string(count) + " labels for " +
                                    std::to_string(input.matrix.values.rows()) + " rows, " +
                                    std::to_string(input.persons.size()) + " persons, " +
                                    std::to_string(input.neighbours.size()) +
                                    " lists of neighbours and " +
                                    std::to_string(input.thumbnails.size()) + " thumbnails");
}

// The bytes that hexadecimal digits stand for.
std::string BytesOf(std::string_view hex) {
  std::string bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2) {
    unsigned value = 0;
    std::from_chars(hex.data() + i, hex.data() + i + 2, value, 16);
    bytes += static_cast<char>(static_cast<uint8_t>(value));
  }
  return bytes;
}

// What the page may do: nothing but its own script, styles and the pictures in it.
std::string Policy(std::string_view script) {
  return "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-" +
         Base64(BytesOf(Sha256::Of(script).Hex())) + "'; base-uri 'none'; form-action 'none'";
}

std::string Head(const ReportInput& input) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"" +
         Policy(kReportScript) +
         "\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<link rel=\"icon\" href=\"data:,\">\n<title>Cohort report: " +
         EscapeMarkup(input.job.set) + "</title>\n<style>\n" + std::string(kReportStyle) +
         ThumbnailStyle(input) + "</style>\n</head>\n";
}

// The id of the first section of `html`, which opens it.
std::string_view Between(std::string_view html, std::string_view open, std::string_view close) {
  const size_t begin = html.find(open) + open.size();
  return html.substr(begin, html.find(close, begin) - begin);
}

std::string Navigation(const std::vector<std::string>& sections) {
  std::string html = "<nav aria-label=\"Sections\"><ul>\n";
  for (const std::string& section : sections) {
    if (section.empty()) continue;
    html += "<li><a href=\"#" + std::string(Between(section, "id=\"", "\"")) + "\">" +
            std::string(Between(section, "<h2>", "</h2>")) + "</a></li>\n";
  }
  return html + "</ul></nav>\n";
}

}  // namespace

absl::StatusOr<std::string> ReportHtml(const ReportInput& input, Executor& executor) {
  COHORT_RETURN_IF_ERROR(CheckSizes(input));
  const ReportAnalysis analysis = Analyze(input);
  COHORT_ASSIGN_OR_RETURN(std::string shape, ShapeSection(input, executor));
  const std::vector<std::string> sections = {SummarySection(input, analysis),
                                             HealthSection(input, analysis),
                                             MatrixSection(input, analysis),
                                             NeighboursSection(input),
                                             DistributionSection(input),
                                             IdentificationSection(input, analysis),
                                             DendrogramSection(input, analysis),
                                             OrdinationSection(input, analysis),
                                             std::move(shape),
                                             RegistrationSection(input, analysis),
                                             ParametersSection(input)};
  std::string html =
      Head(input) + "<body>\n<header>\n<h1>" + EscapeMarkup(input.job.set) +
      "</h1>\n<p class=\"lead\">Cohort: every mesh compared with every other.</p>\n" +
      Navigation(sections) + "</header>\n<main>\n";
  for (const std::string& section : sections) html += section;
  return html + "</main>\n<script>" + std::string(kReportScript) + "</script>\n</body>\n</html>\n";
}

}  // namespace cohort
