// `cohort shape`: how the shapes of a job's meshes vary: modes, groups, and what tells two apart.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/group_variation.h"
#include "client/job_source.h"
#include "client/output/exit_codes.h"
#include "common/analysis/shape_modes.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/geometry/io/write_mesh.h"
#include "common/report/color_map.h"
#include "common/report/csv.h"
#include "common/report/decimal.h"
#include "common/report/quantiles.h"
#include "common/report/render/shape_picture.h"

namespace cohort {
namespace {

constexpr double kModeStep = 2;  ///< Standard deviations to either side.
constexpr double kHighShare = 0.98;

struct ShapeFlags {
  JobSource source;
  std::string out;
  std::string by;
  int modes = 5;
};

std::vector<float> ToFloat(std::span<const double> values) {
  std::vector<float> floats;
  floats.reserve(values.size());
  for (const double value : values) floats.push_back(static_cast<float>(value));
  return floats;
}

/// From 0 to the 98th percentile, or as far to both sides.
ColorScale ScaleFor(std::span<const double> values, ColorScale::Map map) {
  std::vector<double> sizes;
  for (const double value : values) sizes.push_back(std::abs(value));
  ColorScale scale;
  scale.map = map;
  scale.high = QuantileRange(sizes, 0, kHighShare).high;
  scale.low = map == ColorScale::Map::kDiverging ? -scale.high : 0;
  return scale;
}

std::vector<Rgb> ColorsOf(std::span<const double> values, const ColorScale& scale) {
  std::vector<Rgb> colors;
  for (const double value : values) colors.push_back(scale.ColorOf(value));
  return colors;
}

/// Letters, digits and a few signs of a label, for file names.
std::string FileName(const std::string& label) {
  std::string name;
  for (const char c : label) {
    name += absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' ? c : '_';
  }
  return name.substr(0, 80);
}

absl::Status WriteModes(FolderWriter& out, const CorrespondedSet& set, const ShapeModes& modes) {
  std::string table =
      CsvRow(std::vector<std::string>{"mode", "deviation", "explained", "cumulative"});
  double cumulative = 0;
  std::vector<std::string> header = {"file"};
  for (size_t k = 0; k < modes.modes.size(); ++k) {
    cumulative += modes.explained[k];
    table += CsvRow(
        std::vector<std::string>{std::to_string(k + 1), ShortestDecimal(modes.deviations[k]),
                                 ShortestDecimal(modes.explained[k]), ShortestDecimal(cumulative)});
    header.push_back(absl::StrCat("mode_", k + 1));
    const Eigen::VectorXd along = modes.modes[k].cwiseProduct(set.normals).colwise().sum() *
                                  (kModeStep * modes.deviations[k]);
    const std::vector<double> values(along.begin(), along.end());
    const ColorScale scale = ScaleFor(values, ColorScale::Map::kDiverging);
    for (const auto& [name, sign] : {std::pair{"plus", 1.0}, {"minus", -1.0}}) {
      TriangleMesh shape = set.mean_shape;
      shape.vertices = modes.mean + sign * kModeStep * modes.deviations[k] * modes.modes[k];
      std::vector<double> signed_values = values;
      for (double& value : signed_values) value *= sign;
      COHORT_RETURN_IF_ERROR(out.Write(
          {absl::StrCat("mode_", k + 1, "_", name, ".ply"),
           "mean shape and 2 standard deviations of the mode; scalar: displacement along the "
           "normal",
           "mm"},
          WritePly(shape, std::vector<VertexScalar>{{"displacement", ToFloat(signed_values)}},
                   ColorsOf(signed_values, scale))));
    }
  }
  std::string scores = CsvRow(header);
  for (size_t i = 0; i < set.names.size(); ++i) {
    std::vector<std::string> row = {set.names[i]};
    for (Eigen::Index k = 0; k < modes.scores.cols(); ++k) {
      row.push_back(ShortestDecimal(modes.scores(static_cast<Eigen::Index>(i), k)));
    }
    scores += CsvRow(row);
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"modes.csv", "standard deviation and share of each mode", "mm"}, table));
  return out.Write({"scores.csv", "where each mesh lies on the modes", "mm"}, scores);
}

absl::Status WriteGroup(FolderWriter& out,
                        const CorrespondedSet& set,
                        const GroupVariation& group) {
  std::vector<VertexScalar> scalars;
  std::vector<double> rms;
  for (const Metric metric : kAllMetrics) {
    std::vector<double> values;
    for (const MetricValues& at : group.metrics) values.push_back(at[static_cast<size_t>(metric)]);
    std::string name(MetricName(metric));
    std::replace(name.begin(), name.end(), '-', '_');
    scalars.push_back({name, ToFloat(values)});
    if (metric == Metric::kRms) rms = values;
  }
  scalars.push_back({"deviation", ToFloat(group.deviation)});
  scalars.push_back({"signed_mean", ToFloat(group.signed_mean)});
  return out.Write(
      {"variation_" + FileName(group.name) + ".ply",
       absl::StrCat("distances to the ", group.meshes, " meshes of ", group.name), "mm"},
      WritePly(set.mean_shape, scalars,
               ColorsOf(rms, ScaleFor(rms, ColorScale::Map::kSequential))));
}

/// Mean of the second group less mean of the first, along the normal.
absl::Status WriteDifference(FolderWriter& out,
                             const CorrespondedSet& set,
                             const GroupVariation& first,
                             const GroupVariation& second) {
  const Eigen::Matrix3Xd step = second.mean_displacement - first.mean_displacement;
  const Eigen::VectorXd along = step.cwiseProduct(set.normals).colwise().sum();
  const Eigen::VectorXd length = step.colwise().norm();
  const std::vector<double> values(along.begin(), along.end());
  const std::vector<double> lengths(length.begin(), length.end());
  const ColorScale scale = ScaleFor(values, ColorScale::Map::kDiverging);
  const std::string stem = "difference_" + FileName(second.name) + "_minus_" + FileName(first.name);
  COHORT_RETURN_IF_ERROR(
      out.Write({stem + ".ply", "how the mean of one group differs from that of the other", "mm"},
                WritePly(set.mean_shape,
                         std::vector<VertexScalar>{{"along_normal", ToFloat(values)},
                                                   {"length", ToFloat(lengths)}},
                         ColorsOf(values, scale))));
  return out.Write(
      {stem + ".png", "the same from three sides", "mm"},
      ShapeViewsPng(set.mean_shape,
                    {.values = values, .scale = scale, .title = "difference", .unit = "mm"}, {}));
}

/// Positions of the meshes of each value of a label; those without it are in none.
absl::StatusOr<std::map<std::string, std::vector<size_t>>> GroupsBy(const JobFrame& frame,
                                                                    const std::string& column) {
  std::map<std::string, std::vector<size_t>> groups;
  std::map<std::string, int> columns;
  for (size_t i = 0; i < frame.Active().size(); ++i) {
    const auto& labels = frame.Meshes()[static_cast<size_t>(frame.Active()[i])].mesh.labels;
    for (const auto& [name, value] : labels) ++columns[name];
    const auto found = labels.find(column);
    if (found != labels.end() && !found->second.empty()) groups[found->second].push_back(i);
  }
  if (groups.empty()) {
    std::string known;
    for (const auto& [name, count] : columns) known += (known.empty() ? "" : ", ") + name;
    return absl::InvalidArgumentError(
        absl::StrCat("--by ", column, ": no mesh of job ", frame.GetJob().id.value,
                     " has this label; ", known.empty() ? "none has any" : "there are " + known));
  }
  return groups;
}

absl::StatusOr<nlohmann::json> WriteGroups(FolderWriter& out,
                                           const JobFrame& frame,
                                           const CorrespondedSet& set,
                                           const std::string& column,
                                           Executor& executor) {
  COHORT_ASSIGN_OR_RETURN(const auto members, GroupsBy(frame, column));
  std::vector<GroupVariation> groups;
  nlohmann::json json = nlohmann::json::array();
  for (const auto& [name, positions] : members) {
    groups.push_back(VariationOf(set, name, positions, executor));
    COHORT_RETURN_IF_ERROR(WriteGroup(out, set, groups.back()));
    json.push_back({{"group", name}, {"meshes", positions.size()}});
  }
  if (groups.size() == 2) {
    COHORT_RETURN_IF_ERROR(WriteDifference(out, set, groups[0], groups[1]));
  }
  return json;
}

std::string ToText(const ShapeModes& modes, const CorrespondedSet& set, const ShapeFlags& flags) {
  std::string text =
      absl::StrFormat("%d meshes vary by %s mm (RMS over the vertices) around the mean shape\n",
                      set.names.size(), ReadableDecimal(std::sqrt(modes.total_variance), 3));
  double cumulative = 0;
  for (size_t k = 0; k < modes.modes.size(); ++k) {
    cumulative += modes.explained[k];
    text +=
        absl::StrFormat("  mode %d: %5s %%, in all %5s %%, standard deviation %s mm\n", k + 1,
                        FixedDecimal(100 * modes.explained[k], 1),
                        FixedDecimal(100 * cumulative, 1), ReadableDecimal(modes.deviations[k], 3));
  }
  return text + "  " + (std::filesystem::path(flags.out) / "scores.csv").string() +
         ", modes.csv, mode_1_plus.ply, mode_1_minus.ply, ...\n";
}

absl::StatusOr<int> RunShape(const ShapeFlags& flags) {
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  COHORT_ASSIGN_OR_RETURN(const OpenedJob opened, flags.source.Open());
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(*opened.session, opened.Blobs(), opened.id));
  ThreadPool threads(LocalThreads());
  COHORT_ASSIGN_OR_RETURN(const CorrespondedSet set, FindCorrespondences(*frame, threads));
  COHORT_ASSIGN_OR_RETURN(const ShapeModes modes,
                          FindShapeModes(set.displacements, set.mean_shape.vertices, flags.modes));
  FolderWriter out(flags.out);
  COHORT_RETURN_IF_ERROR(WriteModes(out, set, modes));
  nlohmann::json groups;
  if (!flags.by.empty()) {
    COHORT_ASSIGN_OR_RETURN(groups, WriteGroups(out, *frame, set, flags.by, threads));
  }
  const nlohmann::json json = {{"job", opened.id.value},
                               {"meshes", set.names.size()},
                               {"total_variance", modes.total_variance},
                               {"deviations", modes.deviations},
                               {"explained", modes.explained},
                               {"groups", groups}};
  COHORT_RETURN_IF_ERROR(
      out.Write({"shape.json", "the numbers of modes.csv", "mm"}, json.dump(2) + "\n"));
  std::cout << (flags.source.server.json ? json.dump(2) + "\n" : ToText(modes, set, flags));
  return kExitOk;
}

}  // namespace

void AddShapeCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "shape", "how the meshes of a job vary: principal modes of their shape, groups, differences");
  const auto flags = std::make_shared<ShapeFlags>();
  flags->source.AddTo(*command);
  command->add_option("--out", flags->out, "folder; made if new")->required();
  command->add_option("--modes", flags->modes, "principal modes that are written")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--by", flags->by,
                      "label column: variation of each group on the mean shape, and the difference "
                      "of two groups");
  command->callback([flags, &action] { action = [flags] { return RunShape(*flags); }; });
  command->footer(
      "Each mesh is seen from the mean shape: from every vertex to its nearest point of the mesh.\n"
      "Example: cohort shape results --modes 3 --by sex --out shape");
}

}  // namespace cohort
