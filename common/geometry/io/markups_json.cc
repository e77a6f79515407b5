#include "common/geometry/io/markups_json.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/landmark_collector.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

using Json = nlohmann::json;

/// Walks through a JSON text without keeping it: where is it wrong, is it nested too deeply?
class JsonCheck {
 public:
  // The names are those that nlohmann::json calls.
  // NOLINTBEGIN(readability-identifier-naming)
  static bool null() { return true; }
  static bool boolean(bool /*value*/) { return true; }
  static bool number_integer(int64_t /*value*/) { return true; }
  static bool number_unsigned(uint64_t /*value*/) { return true; }
  static bool number_float(double /*value*/, const std::string& /*text*/) { return true; }
  static bool string(const std::string& /*value*/) { return true; }
  static bool binary(const Json::binary_t& /*value*/) { return true; }
  static bool key(const std::string& /*name*/) { return true; }
  bool start_object(size_t /*size*/) { return Enter(); }
  bool end_object() { return Leave(); }
  bool start_array(size_t /*size*/) { return Enter(); }
  bool end_array() { return Leave(); }
  bool parse_error(size_t position, const std::string& /*token*/, const Json::exception& error) {
    position_ = position;
    problem_ = error.what();
    return false;
  }
  // NOLINTEND(readability-identifier-naming)

  [[nodiscard]] bool TooDeep() const { return depth_ > kDeepest; }
  [[nodiscard]] size_t Position() const { return position_; }
  /// Without the number of the exception in front.
  [[nodiscard]] std::string Problem() const {
    const size_t bracket = problem_.find("] ");
    return bracket == std::string::npos ? problem_ : problem_.substr(bracket + 2);
  }

 private:
  static constexpr int kDeepest = 32;
  bool Enter() { return ++depth_ <= kDeepest; }
  bool Leave() {
    --depth_;
    return true;
  }

  int depth_ = 0;
  size_t position_ = 0;
  std::string problem_;
};

/// The string at `key`, or `otherwise` if there is none.
absl::StatusOr<std::string> StringAt(const Json& object,
                                     const char* key,
                                     const std::string& otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) {
    return otherwise;
  }
  if (!found->is_string()) {
    return absl::InvalidArgumentError(absl::StrCat(".", key, ": not a string"));
  }
  return found->get<std::string>();
}

/// What brings the positions of this list to LPS: a factor for each axis.
absl::StatusOr<Eigen::Vector3d> FactorsToLps(const Json& markup) {
  COHORT_ASSIGN_OR_RETURN(const std::string system, StringAt(markup, "coordinateSystem", "LPS"));
  if (system != "LPS" && system != "RAS") {
    return absl::InvalidArgumentError(
        absl::StrCat(".coordinateSystem: ", Quoted(system), "; LPS and RAS can be read"));
  }
  // Either "mm" or ["mm", "UCUM", "millimeter"].
  const auto units = markup.find("coordinateUnits");
  const Json unit = units == markup.end()                  ? Json("mm")
                    : units->is_array() && !units->empty() ? units->front()
                                                           : *units;
  if (unit != "mm") {
    return absl::InvalidArgumentError(".coordinateUnits: only mm can be read");
  }
  return system == "RAS" ? Eigen::Vector3d(-1, -1, 1) : Eigen::Vector3d(1, 1, 1);
}

absl::StatusOr<Eigen::Vector3d> PositionOf(const Json& control_point) {
  const auto position = control_point.find("position");
  const bool three_numbers = position != control_point.end() && position->is_array() &&
                             position->size() == 3 &&
                             std::all_of(position->begin(), position->end(), [](const Json& value) {
                               return value.is_number() && std::isfinite(value.get<double>());
                             });
  if (!three_numbers) {
    return absl::InvalidArgumentError(".position: not three finite numbers");
  }
  return Eigen::Vector3d((*position)[0].get<double>(), (*position)[1].get<double>(),
                         (*position)[2].get<double>());
}

struct ControlPoint {
  std::string label;
  bool defined = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< As in the file.
};

absl::StatusOr<ControlPoint> ParseControlPoint(const Json& json) {
  if (!json.is_object()) {
    return absl::InvalidArgumentError(": not an object");
  }
  ControlPoint point;
  COHORT_ASSIGN_OR_RETURN(point.label, StringAt(json, "label", ""));
  COHORT_ASSIGN_OR_RETURN(const std::string status, StringAt(json, "positionStatus", "defined"));
  point.defined = status == "defined";
  if (point.defined) {
    COHORT_ASSIGN_OR_RETURN(point.position, PositionOf(json));
  }
  return point;
}

absl::Status AddMarkup(const Json& markup,
                       std::string_view file,
                       const std::string& place,
                       LandmarkCollector& collector) {
  if (!markup.is_object()) {
    return FileError(file, absl::StrCat(place, ": not an object"));
  }
  const auto to_lps = FactorsToLps(markup);
  if (!to_lps.ok()) {
    return FileError(file, absl::StrCat(place, to_lps.status().message()));
  }
  const auto points = markup.find("controlPoints");
  if (points == markup.end()) {
    return absl::OkStatus();
  }
  if (!points->is_array()) {
    return FileError(file, absl::StrCat(place, ".controlPoints: not an array"));
  }
  for (size_t i = 0; i < points->size(); ++i) {
    const std::string point_place = absl::StrCat(place, ".controlPoints[", i, "]");
    const auto point = ParseControlPoint((*points)[i]);
    if (!point.ok()) {
      return FileError(file, absl::StrCat(point_place, point.status().message()));
    }
    COHORT_RETURN_IF_ERROR(point->defined ? collector.Add(point_place, "", point->label,
                                                          point->position.cwiseProduct(*to_lps))
                                          : collector.AddMissing(point_place, "", point->label));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<MeshLandmarks>> ReadMarkupsJson(std::string_view bytes,
                                                           std::string_view file_name,
                                                           const LandmarkLimits& limits) {
  JsonCheck check;
  if (!Json::sax_parse(bytes, &check)) {
    return check.TooDeep() ? FileError(file_name, "the JSON is nested too deeply")
                           : ByteError(file_name, check.Position(), check.Problem());
  }
  const Json json = Json::parse(bytes, nullptr, /*allow_exceptions=*/false);
  const auto markups = json.is_object() ? json.find("markups") : json.end();
  if (markups == json.end() || !markups->is_array()) {
    return FileError(file_name, "no array 'markups' in the JSON; is this a file of Slicer's?");
  }
  LandmarkCollector collector(file_name, limits);
  for (size_t m = 0; m < markups->size(); ++m) {
    COHORT_RETURN_IF_ERROR(
        AddMarkup((*markups)[m], file_name, absl::StrCat("markups[", m, "]"), collector));
  }
  return std::move(collector).Take();
}

}  // namespace cohort
