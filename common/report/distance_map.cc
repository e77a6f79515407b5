#include "common/report/distance_map.h"

#include <cmath>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/geometry/io/write_mesh.h"
#include "common/report/quantiles.h"

namespace cohort {
namespace {

constexpr double kHighShare = 0.98;

}  // namespace

ColorScale DistanceScale(std::span<const float> distances, DistanceSign sign) {
  std::vector<double> sizes;
  sizes.reserve(distances.size());
  for (const float distance : distances) {
    sizes.push_back(std::abs(double{distance}));
  }
  ColorScale scale;
  scale.map =
      sign == DistanceSign::kSigned ? ColorScale::Map::kDiverging : ColorScale::Map::kSequential;
  scale.high = QuantileRange(sizes, 0, kHighShare).high;
  scale.low = sign == DistanceSign::kSigned ? -scale.high : 0;
  return scale;
}

absl::StatusOr<std::string> DistanceMapPly(const TriangleMesh& mesh,
                                           std::span<const float> distances,
                                           const ColorScale& scale) {
  if (std::ssize(distances) != mesh.VertexCount()) {
    return absl::InvalidArgumentError(absl::StrCat("distance map: ", distances.size(),
                                                   " distances for a mesh of ", mesh.VertexCount(),
                                                   " vertices"));
  }
  std::vector<Rgb> colors;
  colors.reserve(distances.size());
  for (const float distance : distances) {
    colors.push_back(scale.ColorOf(double{distance}));
  }
  const std::vector<VertexScalar> scalars = {
      {.name = "distance", .values = {distances.begin(), distances.end()}}};
  return WritePly(mesh, scalars, colors);
}

}  // namespace cohort
