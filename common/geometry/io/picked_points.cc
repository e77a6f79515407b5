#include "common/geometry/io/picked_points.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include <pugixml.hpp>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/landmark_collector.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

/// Lines up to places in the text that only ever move on.
class LineCounter {
 public:
  explicit LineCounter(std::string_view text) : text_(text) {}

  int64_t LineOf(std::ptrdiff_t offset) {
    const size_t end = std::min(static_cast<size_t>(offset), text_.size());
    for (; at_ < end; ++at_) {
      line_ += text_[at_] == '\n' ? 1 : 0;
    }
    return line_;
  }

 private:
  std::string_view text_;
  size_t at_ = 0;
  int64_t line_ = 1;
};

struct PickedPoint {
  const char* name = "";
  bool active = true;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

absl::StatusOr<PickedPoint> ParsePoint(const pugi::xml_node& node) {
  PickedPoint point;
  point.name = node.attribute("name").value();
  const std::string_view active = node.attribute("active").as_string("1");
  if (active != "0" && active != "1") {
    return absl::InvalidArgumentError(absl::StrCat("active is ", Quoted(active), ", not 0 or 1"));
  }
  point.active = active == "1";
  constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  for (size_t axis = 0; axis < 3 && point.active; ++axis) {
    const pugi::xml_attribute attribute = node.attribute(kAxes[axis]);
    if (attribute.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("it has no ", kAxes[axis]));
    }
    if (!ParseNumber(attribute.value(), point.position(static_cast<Eigen::Index>(axis)))) {
      return absl::InvalidArgumentError(
          absl::StrCat(kAxes[axis], " is ", Quoted(attribute.value()), ", not a finite number"));
    }
  }
  return point;
}

}  // namespace

absl::StatusOr<std::vector<MeshLandmarks>> ReadPickedPoints(std::string_view bytes,
                                                            std::string_view file_name,
                                                            const LandmarkLimits& limits) {
  LineCounter lines(bytes);
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(bytes.data(), bytes.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    return LineError(file_name, lines.LineOf(parsed.offset),
                     absl::StrCat("not well-formed XML: ", parsed.description()));
  }
  const pugi::xml_node root = document.document_element();
  if (std::strcmp(root.name(), "PickedPoints") != 0) {
    return FileError(file_name, absl::StrCat("the XML is ", Quoted(root.name()),
                                             ", not MeshLab's 'PickedPoints'"));
  }
  LandmarkCollector collector(file_name, limits);
  for (const pugi::xml_node& node : root.children("point")) {
    const int64_t line = lines.LineOf(node.offset_debug());
    const auto point = ParsePoint(node);
    if (!point.ok()) {
      return LineError(file_name, line,
                       absl::StrCat("point ", Quoted(node.attribute("name").value()), ": ",
                                    point.status().message()));
    }
    const std::string place = absl::StrCat("line ", line);
    COHORT_RETURN_IF_ERROR(point->active ? collector.Add(place, "", point->name, point->position)
                                         : collector.AddMissing(place, "", point->name));
  }
  return std::move(collector).Take();
}

}  // namespace cohort
