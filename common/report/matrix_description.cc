#include "common/report/matrix_description.h"

namespace cohort {

namespace {

std::string AlignedText(Method method) {
  switch (method) {
    case Method::kAverage:
      return "Aligned to the mean shape";
    case Method::kOne:
      return "Aligned to the base mesh";
    case Method::kEach:
      return "Each pair aligned, source to target";
    case Method::kNone:
      return "Not aligned";
  }
  return "";
}

}  // namespace

std::string MethodText(const MatrixDescription& description) {
  const bool is_fidentis = description.arithmetic == Arithmetic::kFidentis;
  return AlignedText(description.method) + " (method " +
         std::string(MethodName(description.method)) + (is_fidentis ? ", preset fidentis)" : ")");
}

std::string MetricText(const MatrixDescription& description) {
  if (description.is_preview) return "Corresponded RMS (preview)";
  const std::string title(MetricTitle(description.metric));
  return description.sign == DistanceSign::kSigned ? title + " (signed)" : title;
}

std::string ValueUnit(const MatrixDescription& description) {
  const bool is_square = description.metric == Metric::kVariance && !description.unit.empty();
  return is_square ? description.unit + "²" : description.unit;
}

std::string ValueTitle(const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  if (unit.empty()) return MetricText(description);
  if (description.is_preview || description.sign == DistanceSign::kAbsolute) {
    return MetricText(description) + " (" + unit + ")";
  }
  return std::string(MetricTitle(description.metric)) + " (signed, " + unit + ")";
}

std::string WithUnit(const std::string& number, const MatrixDescription& description) {
  const std::string unit = ValueUnit(description);
  return unit.empty() ? number : number + " " + unit;
}

std::string Counted(int64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace cohort
