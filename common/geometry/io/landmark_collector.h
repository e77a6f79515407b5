#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/io/landmarks.h"

namespace cohort {

/// Gathers the landmarks that a reader finds and refuses what no file may have: names that are
/// empty, too long or there twice, too many points. Internal to io; not thread-safe.
class LandmarkCollector {
 public:
  LandmarkCollector(std::string_view file, const LandmarkLimits& limits)
      : file_(file), limits_(limits) {}

  /// @param place  begins the message: "line 7", "markups[0].controlPoints[3]".
  /// @param mesh  empty if the file names none.
  [[nodiscard]] absl::Status Add(const std::string& place,
                                 std::string_view mesh,
                                 std::string_view name,
                                 const Eigen::Vector3d& point);

  /// A landmark that the file has but that has no position: its name must be in order all the same.
  [[nodiscard]] absl::Status AddMissing(const std::string& place,
                                        std::string_view mesh,
                                        std::string_view name);

  /// @return kInvalidArgument if there are no landmarks at all.
  [[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> Take() &&;

 private:
  struct Gathered {
    std::vector<std::string> names;
    std::vector<Eigen::Vector3d> points;
  };
  [[nodiscard]] absl::Status CheckName(const std::string& place, std::string_view name) const;
  [[nodiscard]] absl::Status Error(const std::string& place, const std::string& reason) const;
  size_t PlaceOf(std::string_view mesh);

  std::string file_;
  LandmarkLimits limits_;
  std::vector<std::string> meshes_;  ///< In the order of their first rows.
  std::vector<Gathered> gathered_;   ///< Of each mesh.
  std::map<std::string, size_t, std::less<>> place_of_;
  std::map<std::pair<size_t, std::string>, std::string> first_place_;  ///< Of each name.
};

}  // namespace cohort
