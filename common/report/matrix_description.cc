#include "common/report/matrix_description.h"

namespace cohort {

std::string MethodText(Method method) {
  switch (method) {
    case Method::kAverage:
      return "Aligned to the mean shape (method average)";
    case Method::kOne:
      return "Aligned to the base mesh (method one)";
    case Method::kEach:
      return "Each pair aligned, source to target (method each)";
    case Method::kNone:
      return "Not aligned (method none)";
  }
  return "";
}

std::string ValueUnit(const MatrixDescription& description) {
  const bool is_square = description.metric == Metric::kVariance && !description.unit.empty();
  return is_square ? description.unit + "²" : description.unit;
}

std::string MetricText(const MatrixDescription& description) {
  return description.is_preview ? "Corresponded RMS (preview)"
                                : std::string(MetricTitle(description.metric));
}

std::string ValueTitle(const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  const std::string title = MetricText(description);
  return unit.empty() ? title : title + " (" + unit + ")";
}

std::string WithUnit(const std::string& number, const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  return unit.empty() ? number : number + " " + unit;
}

std::string Counted(int64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace cohort
