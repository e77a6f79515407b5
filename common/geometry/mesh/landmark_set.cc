#include "common/geometry/mesh/landmark_set.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <map>

namespace cohort {

int64_t LandmarkSet::IndexOf(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : found - names.begin();
}

std::vector<std::string> CommonLandmarks(std::span<const LandmarkSet> sets) {
  std::vector<std::string> common;
  for (size_t s = 0; s < sets.size(); ++s) {
    std::vector<std::string> names = sets[s].names;
    std::sort(names.begin(), names.end());
    if (s == 0) {
      common = std::move(names);
      continue;
    }
    std::vector<std::string> both;
    std::set_intersection(common.begin(), common.end(), names.begin(), names.end(),
                          std::back_inserter(both));
    common = std::move(both);
  }
  return common;
}

Eigen::Matrix3Xd PointsOf(const LandmarkSet& set, std::span<const std::string> names) {
  assert(static_cast<int64_t>(set.names.size()) == set.Count());
  std::map<std::string_view, Eigen::Index> column_of;
  for (size_t i = 0; i < set.names.size(); ++i) {
    column_of.emplace(set.names[i], static_cast<Eigen::Index>(i));
  }
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(names.size()));
  for (size_t i = 0; i < names.size(); ++i) {
    const auto found = column_of.find(names[i]);
    assert(found != column_of.end());
    points.col(static_cast<Eigen::Index>(i)) = set.points.col(found->second);
  }
  return points;
}

}  // namespace cohort
