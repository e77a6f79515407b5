#include "common/pairs/vertex_weights.h"

#include <cmath>

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include "common/geometry/mesh/vertex_areas.h"
#include "common/geometry/nearest/packet_search.h"

namespace cohort {

absl::StatusOr<std::vector<double>> ParseRegionWeights(const std::string& text,
                                                       const std::string& file_name,
                                                       int64_t vertices) {
  std::vector<double> weights;
  bool has_positive = false;
  int64_t line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line.front() == '#') {
      continue;
    }
    double weight = 0;
    if (!absl::SimpleAtod(line, &weight) || !(weight >= 0) || !std::isfinite(weight)) {
      return absl::InvalidArgumentError(absl::StrCat(
          file_name, ":", line_number, ": \"", line.substr(0, 40),
          "\" is not a weight: expected one number >= 0 per line, one line per vertex"));
    }
    has_positive = has_positive || weight > 0;
    weights.push_back(weight);
  }
  if (std::ssize(weights) != vertices) {
    return absl::InvalidArgumentError(absl::StrCat(file_name, ": ", weights.size(),
                                                   " weights for the ", vertices,
                                                   " vertices of mean_shape.ply"));
  }
  if (!has_positive) {
    return absl::InvalidArgumentError(
        absl::StrCat(file_name, ": all weights are 0: no part of the mean shape would count"));
  }
  return weights;
}

std::vector<double> SlotWeights(const TriangleMesh& mesh,
                                const PackedMesh& placed,
                                bool by_area,
                                const RegionMask* region) {
  std::vector<double> weights(static_cast<size_t>(placed.VertexCount()), 1.0);
  if (by_area) {
    const Eigen::VectorXd areas = VertexAreas(mesh);
    for (size_t slot = 0; slot < weights.size(); ++slot) {
      weights[slot] = areas(placed.VertexOfSlot()[slot]);
    }
  }
  if (region != nullptr) {
    PacketSearch search;
    NearestSlots nearest;
    search.Find(placed, region->reference, nearest);
    for (size_t slot = 0; slot < weights.size(); ++slot) {
      const auto found = static_cast<size_t>(nearest.slots[slot]);
      weights[slot] *=
          region->weights[static_cast<size_t>(region->reference.VertexOfSlot()[found])];
    }
  }
  return weights;
}

}  // namespace cohort
