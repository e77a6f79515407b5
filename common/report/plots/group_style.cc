#include "common/report/plots/group_style.h"

#include <array>
#include <set>
#include <utility>

namespace cohort {

Groups MakeGroups(std::string title, std::span<const std::string> values) {
  std::set<std::string> names(values.begin(), values.end());
  names.erase("");
  Groups groups{std::move(title), {names.begin(), names.end()}, {}};
  std::map<std::string, int> index;
  for (size_t i = 0; i < groups.names.size(); ++i) index[groups.names[i]] = static_cast<int>(i);
  groups.group_of.reserve(values.size());
  for (const std::string& value : values) {
    groups.group_of.push_back(value.empty() ? -1 : index.at(value));
  }
  return groups;
}

GroupStyle StyleOfGroup(int group) {
  constexpr std::array<Rgb, 7> kColors = {{{0, 114, 178},
                                           {213, 94, 0},
                                           {0, 158, 115},
                                           {204, 121, 167},
                                           {230, 159, 0},
                                           {86, 180, 233},
                                           {40, 40, 40}}};
  constexpr std::array<MarkShape, 4> kShapes = {MarkShape::kCircle, MarkShape::kSquare,
                                                MarkShape::kTriangle, MarkShape::kDiamond};
  if (group < 0) return {kNoValueColor, MarkShape::kCircle};
  const auto number = static_cast<size_t>(group);
  return {kColors[number % kColors.size()], kShapes[number / kColors.size() % kShapes.size()]};
}

}  // namespace cohort
