#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <absl/status/statusor.h>
#include <nlohmann/json.hpp>

#include "client/folder_writer.h"
#include "client/job_frame.h"
#include "common/pairs/measure_spec.h"

namespace cohort {

/// A mesh of a pair that is looked at alone.
struct PairSide {
  std::string name;
  const FramedMesh& mesh;
};

/// What was measured from one side of a pair to the other.
struct SideDistances {
  std::string source;
  std::string target;
  std::vector<float> distances;  ///< Per vertex of the source's mesh; NaN: does not count.
  int64_t counted = 0;
  MetricValues metrics{};
  double percentile_95 = 0;
};

/// Both directions of a pair, measured in the frame that both were placed in.
/// @param sign  both meshes made for it.
[[nodiscard]] absl::StatusOr<std::vector<SideDistances>> MeasureSides(const PairSide& a,
                                                                      const PairSide& b,
                                                                      const CompareOptions& compare,
                                                                      DistanceSign sign);

/// Numbers of both directions, for scripts.
[[nodiscard]] nlohmann::json SidesToJson(const std::vector<SideDistances>& sides,
                                         DistanceSign sign);
/// The same for the screen: a small table.
[[nodiscard]] std::string SidesToText(const std::vector<SideDistances>& sides);

/// Writes for each direction distances_a_to_b (.ply with scalar and colours, .csv, .png) and
/// distances_b_to_a, a histogram of both, and `numbers` as pair.json.
[[nodiscard]] absl::Status WritePairFiles(const std::filesystem::path& folder,
                                          const PairSide& a,
                                          const PairSide& b,
                                          const std::vector<SideDistances>& sides,
                                          DistanceSign sign,
                                          const nlohmann::json& numbers);

}  // namespace cohort
