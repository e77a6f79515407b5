#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/report/plots/svg_page.h"

namespace cohort {

/// Which of some groups each mesh is in, e.g. by person.
struct Groups {
  std::string title;               ///< What they are by: "person".
  std::vector<std::string> names;  ///< In bytewise order.
  std::vector<int> group_of;       ///< One per mesh, index into `names`; -1: not known.
};

/// @param values  one per mesh, "" for unknown.
[[nodiscard]] Groups MakeGroups(std::string title, std::span<const std::string> values);

/// How the points of a group look: 7 colours (Okabe, Ito 2008, without yellow) x 4 shapes, then
/// again; grey for -1.
struct GroupStyle {
  Rgb color;
  MarkShape shape = MarkShape::kCircle;
};
[[nodiscard]] GroupStyle StyleOfGroup(int group);

}  // namespace cohort
