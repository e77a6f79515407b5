#include "common/report/gpa_report.h"

#include <cassert>

#include <nlohmann/json.hpp>

#include "common/report/csv.h"
#include "common/report/decimal.h"

namespace cohort {
namespace {

using Json = nlohmann::ordered_json;

bool IsNormalized(const GpaReport& report) {
  return report.options.size == ProcrustesSize::kNormalized;
}

}  // namespace

std::string_view ProcrustesSizeName(ProcrustesSize size) {
  return size == ProcrustesSize::kKept ? "kept" : "normalized";
}

std::string_view ProcrustesVariantName(ProcrustesOptions::Variant variant) {
  return variant == ProcrustesOptions::Variant::kExact ? "exact" : "fidentis";
}

MetricMatrix GpaMatrix(const GpaReport& report) {
  MetricMatrix matrix;
  for (const GpaSet& set : report.sets) {
    matrix.labels.push_back(set.name);
  }
  matrix.values = report.analysis.distances;
  return matrix;
}

MatrixDescription DescribeGpa(const GpaReport& report) {
  MatrixDescription description;
  description.unit = IsNormalized(report) ? "" : "mm";
  description.title = "Procrustes distance";
  description.subtitle =
      Counted(static_cast<int64_t>(report.analysis.names.size()), "landmark", "landmarks") +
      (IsNormalized(report) ? ", centroid size 1 (shape)" : ", sizes kept (form)");
  if (report.options.variant == ProcrustesOptions::Variant::kFidentis) {
    description.subtitle += ", as FIDENTIS Analyst";
  }
  return description;
}

std::string GpaSetsCsv(const GpaReport& report) {
  std::string csv =
      CsvRow(std::vector<std::string>{"file", "landmarks", "centroid_size", "distance_to_mean"});
  for (size_t s = 0; s < report.sets.size(); ++s) {
    const auto place = static_cast<Eigen::Index>(s);
    csv += CsvRow(
        std::vector<std::string>{report.sets[s].name, std::to_string(report.sets[s].landmarks),
                                 ShortestDecimal(report.analysis.centroid_sizes(place)),
                                 ShortestDecimal(report.analysis.distances_to_mean(place))});
  }
  return csv;
}

std::string GpaJson(const GpaReport& report,
                    std::span<const GpaInput> inputs,
                    std::span<const ResultFile> files,
                    const std::string& software_version) {
  Json json;
  json["software"] = software_version;
  json["method"] = "gpa";
  json["parameters"] = {{"size", std::string(ProcrustesSizeName(report.options.size))},
                        {"variant", std::string(ProcrustesVariantName(report.options.variant))},
                        {"tolerance", report.options.tolerance},
                        {"max_iterations", report.options.max_iterations}};
  json["iterations"] = report.analysis.iterations;
  json["converged"] = report.analysis.converged;
  json["landmarks"] = report.analysis.names;
  json["landmarks_left_out"] = report.left_out;
  json["sets"] = Json::array();
  for (const GpaSet& set : report.sets) {
    json["sets"].push_back({{"name", set.name}, {"file", set.file}, {"landmarks", set.landmarks}});
  }
  json["inputs"] = Json::array();
  for (const GpaInput& input : inputs) {
    json["inputs"].push_back({{"name", input.name}, {"sha256", input.sha256.Hex()}});
  }
  json["files"] = Json::array();
  for (const ResultFile& file : files) {
    json["files"].push_back(
        {{"name", file.name}, {"description", file.description}, {"unit", file.unit}});
  }
  // As in job.json: file names may be any bytes.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cohort
