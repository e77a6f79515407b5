#include "client/pair_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "common/base/status_macros.h"
#include "common/pairs/distance_finder.h"
#include "common/report/csv.h"
#include "common/report/decimal.h"
#include "common/report/distance_histogram.h"
#include "common/report/distance_map.h"
#include "common/report/render/shape_picture.h"

namespace cohort {
namespace {

constexpr double kHighPercentile = 0.95;
constexpr std::array<const char*, 2> kFileStems = {"distances_a_to_b", "distances_b_to_a"};

absl::StatusOr<SideDistances> MeasureSide(const PairSide& source,
                                          const PairSide& target,
                                          DistanceSign sign,
                                          DistanceFinder& finder) {
  const PairDistances& found = finder.Find(source.mesh.placed, target.mesh.placed);
  SideDistances side;
  side.source = source.name;
  side.target = target.name;
  side.counted = std::ssize(found.distances);
  side.distances.assign(static_cast<size_t>(source.mesh.mesh.VertexCount()),
                        std::numeric_limits<float>::quiet_NaN());
  const std::span<const int32_t> vertices = source.mesh.placed.vertices.VertexOfSlot();
  for (size_t i = 0; i < found.slots.size(); ++i) {
    const auto slot = static_cast<size_t>(found.slots[i]);
    side.distances[static_cast<size_t>(vertices[slot])] = found.distances[i];
  }
  if (found.distances.empty()) {
    side.metrics.fill(std::numeric_limits<double>::quiet_NaN());
    side.percentile_95 = std::numeric_limits<double>::quiet_NaN();
    return side;
  }
  FieldOptions options;
  options.sign = sign;
  options.percentile = kHighPercentile;
  COHORT_ASSIGN_OR_RETURN(const FieldMeasure measured, MeasureField(found.distances, options));
  side.metrics = measured.metrics;
  side.percentile_95 = measured.percentile;
  return side;
}

/// Where the mesh lies in the frame of the pair, not centred.
TriangleMesh Placed(const FramedMesh& framed) {
  return {.vertices = framed.T_frame_mesh.Apply(framed.mesh.vertices), .faces = framed.mesh.faces};
}

std::string DistancesCsv(const TriangleMesh& mesh, std::span<const float> distances) {
  std::string csv = CsvRow(std::array<std::string, 5>{"vertex", "x", "y", "z", "distance"});
  for (size_t i = 0; i < distances.size(); ++i) {
    const auto vertex = mesh.vertices.col(static_cast<Eigen::Index>(i));
    csv += CsvRow(std::array<std::string, 5>{
        std::to_string(i), ShortestDecimal(vertex.x()), ShortestDecimal(vertex.y()),
        ShortestDecimal(vertex.z()), ShortestDecimal(double{distances[i]})});
  }
  return csv;
}

absl::Status WriteSide(FolderWriter& out,
                       const std::string& stem,
                       const TriangleMesh& mesh,
                       const SideDistances& side,
                       DistanceSign sign) {
  const ColorScale scale = DistanceScale(side.distances, sign);
  COHORT_RETURN_IF_ERROR(
      out.Write({stem + ".ply", "the source with its distances as scalar and colour", "mm"},
                DistanceMapPly(mesh, side.distances, scale)));
  COHORT_RETURN_IF_ERROR(
      out.Write({stem + ".csv", "the same as a table", "mm"}, DistancesCsv(mesh, side.distances)));
  const std::vector<double> values(side.distances.begin(), side.distances.end());
  return out.Write(
      {stem + ".png", "the same from three sides", "mm"},
      ShapeViewsPng(mesh,
                    {.values = values,
                     .scale = scale,
                     .title = sign == DistanceSign::kSigned ? "signed distance" : "distance",
                     .unit = "mm"},
                    {}));
}

nlohmann::json Number(double value) {
  return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
}

}  // namespace

absl::StatusOr<std::vector<SideDistances>> MeasureSides(const PairSide& a,
                                                        const PairSide& b,
                                                        const CompareOptions& compare,
                                                        DistanceSign sign) {
  DistanceFinder finder(compare, sign);
  std::vector<SideDistances> sides;
  COHORT_ASSIGN_OR_RETURN(SideDistances there, MeasureSide(a, b, sign, finder));
  COHORT_ASSIGN_OR_RETURN(SideDistances back, MeasureSide(b, a, sign, finder));
  sides.push_back(std::move(there));
  sides.push_back(std::move(back));
  return sides;
}

nlohmann::json SidesToJson(const std::vector<SideDistances>& sides, DistanceSign sign) {
  nlohmann::json list = nlohmann::json::array();
  for (const SideDistances& side : sides) {
    nlohmann::json metrics;
    for (const Metric metric : kAllMetrics) {
      metrics[std::string(MetricName(metric))] = Number(side.metrics[static_cast<size_t>(metric)]);
    }
    metrics["p95"] = Number(side.percentile_95);
    list.push_back({{"source", side.source},
                    {"target", side.target},
                    {"vertices", side.distances.size()},
                    {"counted", side.counted},
                    {"metrics", metrics}});
  }
  return {{"sign", std::string(DistanceSignName(sign))}, {"unit", "mm"}, {"directions", list}};
}

std::string SidesToText(const std::vector<SideDistances>& sides) {
  std::string text = absl::StrFormat("  %-28s %14s %14s\n", "", "a to b", "b to a");
  const auto row = [&](const std::string& name, double there, double back, const char* unit) {
    text += absl::StrFormat("  %-28s %14s %14s %s\n", name, ReadableDecimal(there, 4),
                            ReadableDecimal(back, 4), unit);
  };
  for (const Metric metric : kAllMetrics) {
    const auto at = static_cast<size_t>(metric);
    row(std::string(MetricTitle(metric)), sides[0].metrics[at], sides[1].metrics[at],
        metric == Metric::kVariance ? "mm²" : "mm");
  }
  row("95th percentile", sides[0].percentile_95, sides[1].percentile_95, "mm");
  text += absl::StrFormat("  %-28s %14d %14d\n", "vertices that count", sides[0].counted,
                          sides[1].counted);
  return text;
}

absl::Status WritePairFiles(const std::filesystem::path& folder,
                            const PairSide& a,
                            const PairSide& b,
                            const std::vector<SideDistances>& sides,
                            DistanceSign sign,
                            const nlohmann::json& numbers) {
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  FolderWriter out(folder);
  const std::array<const PairSide*, 2> sources = {&a, &b};
  for (size_t i = 0; i < sources.size(); ++i) {
    COHORT_RETURN_IF_ERROR(WriteSide(out, kFileStems[i], Placed(sources[i]->mesh), sides[i], sign));
  }
  const auto direction = [](const SideDistances& side) {
    return DistanceSeries{.name = side.source + " to " + side.target, .distances = side.distances};
  };
  COHORT_RETURN_IF_ERROR(
      out.Write({"histogram.png", "distribution of the distances", "mm"},
                DistanceHistogramPng(
                    direction(sides[0]), direction(sides[1]), "Distances of a pair of meshes",
                    sign == DistanceSign::kSigned ? "signed distance (mm)" : "distance (mm)")));
  return out.Write({"pair.json", "numbers of both directions", "mm"}, numbers.dump(2) + "\n");
}

}  // namespace cohort
