#include "common/report/csv.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <map>
#include <optional>
#include <set>

#include "common/report/decimal.h"
#include "common/report/job_meshes.h"

namespace cohort {
namespace {

constexpr std::string_view kMissing = "NA";
constexpr std::string_view kLineEnd = "\r\n";

constexpr std::array<std::string_view, 3> kStatusColumns = {"file", "status", "reason"};
constexpr std::array<std::string_view, 4> kFileColumns = {"sha256", "size_bytes", "vertices",
                                                          "faces"};
constexpr std::array<std::string_view, 15> kHealthColumns = {
    "file_vertices",         "file_faces",       "duplicate_vertices",
    "unreferenced_vertices", "degenerate_faces", "duplicate_faces",
    "non_manifold_edges",    "components",       "largest_component_share",
    "boundary_share",        "diagonal",         "rms_radius",
    "surface_area",          "point_cloud",      "warnings"};
constexpr std::array<std::string_view, 8> kAlignmentColumns = {
    "iterations", "converged",      "rms_residual", "mean_residual",
    "scale",      "at_scale_limit", "overlap",      "kept_share"};

constexpr std::array<std::string_view, 2> kLastColumns = {"pose_rms", "asymmetry"};

using Fields = std::vector<std::string>;

void AppendField(std::string_view field, std::string& csv) {
  const bool has_outer_space = !field.empty() && (field.front() == ' ' || field.back() == ' ' ||
                                                  field.front() == '\t' || field.back() == '\t');
  if (!has_outer_space && field.find_first_of(",\"\r\n") == std::string_view::npos) {
    csv += field;
    return;
  }
  csv += '"';
  for (const char c : field) {
    if (c == '"') csv += '"';
    csv += c;
  }
  csv += '"';
}

template <typename Names>
void AppendNames(const Names& names, Fields& fields) {
  fields.insert(fields.end(), names.begin(), names.end());
}

void AppendMissing(size_t count, Fields& fields) {
  fields.insert(fields.end(), count, std::string(kMissing));
}

// Counts and measures; integers stay integers.
std::string Text(int64_t value) {
  return std::to_string(value);
}
std::string Text(double value) {
  return ShortestDecimal(value);
}
std::string TruthText(bool value) {
  return value ? "TRUE" : "FALSE";
}

std::string Joined(std::span<const std::string> lines) {
  std::string text;
  for (const std::string& line : lines) {
    if (!text.empty()) text += "; ";
    text += line;
  }
  return text;
}

bool IsFixedColumn(std::string_view name) {
  const auto has = [name](const auto& columns) {
    return std::find(columns.begin(), columns.end(), name) != columns.end();
  };
  return has(kStatusColumns) || has(kFileColumns) || has(kHealthColumns) ||
         has(kAlignmentColumns) || has(kLastColumns);
}

std::set<std::string> LabelKeys(std::span<const JobMesh> meshes) {
  std::set<std::string> keys;
  for (const JobMesh& mesh : meshes) {
    for (const auto& [key, value] : mesh.mesh.labels) keys.insert(key);
  }
  return keys;
}

void AppendLabels(const SetMesh& mesh, const std::set<std::string>& keys, Fields& fields) {
  for (const std::string& key : keys) {
    const auto label = mesh.labels.find(key);
    fields.emplace_back(label == mesh.labels.end() ? kMissing : std::string_view(label->second));
  }
}

void AppendIngested(const std::optional<IngestedMesh>& mesh, Fields& fields) {
  if (!mesh) {
    AppendMissing(2 + kHealthColumns.size(), fields);
    return;
  }
  const MeshHealth& health = mesh->health;
  AppendNames(
      std::array{Text(mesh->vertices), Text(mesh->faces), Text(health.vertices), Text(health.faces),
                 Text(health.duplicate_vertices), Text(health.unreferenced_vertices),
                 Text(health.degenerate_faces), Text(health.duplicate_faces),
                 Text(health.non_manifold_edges), Text(health.components),
                 Text(health.largest_component_share), Text(health.boundary_share),
                 Text(health.diagonal), Text(health.rms_radius), Text(health.surface_area),
                 TruthText(health.point_cloud), Joined(health.warnings)},
      fields);
}

void AppendAlignment(const Alignment* alignment, Fields& fields) {
  if (alignment == nullptr) {
    AppendMissing(kAlignmentColumns.size(), fields);
    return;
  }
  AppendNames(
      std::array{Text(int64_t{alignment->iterations}), TruthText(alignment->converged),
                 Text(alignment->rms_residual), Text(alignment->mean_residual),
                 Text(alignment->T_target_source.scale), TruthText(alignment->at_scale_limit),
                 Text(alignment->overlap), Text(alignment->kept_share)},
      fields);
}

// By index of the mesh; the last one counts if a mesh has several.
std::map<int32_t, const Alignment*> ByMesh(std::span<const MeshAlignment> alignments) {
  std::map<int32_t, const Alignment*> by_mesh;
  for (const MeshAlignment& entry : alignments) by_mesh[entry.mesh] = &entry.alignment;
  return by_mesh;
}

std::string SamePersonText(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? std::string(kMissing) : TruthText(a == b);
}
std::string PersonText(const std::string& person) {
  return person.empty() ? std::string(kMissing) : person;
}

}  // namespace

std::string CsvRow(std::span<const std::string> fields) {
  std::string row;
  for (size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) row += ',';
    AppendField(fields[i], row);
  }
  row += kLineEnd;
  return row;
}

std::string MatrixCsv(const MatrixView& matrix, Metric metric) {
  return MatrixCsv(matrix, MetricName(metric));
}

std::string MatrixCsv(const MatrixView& matrix, std::string_view corner) {
  const Eigen::Index count = std::ssize(matrix.labels);
  assert(matrix.values.rows() == count && matrix.values.cols() == count);
  std::string csv = MatrixCsvHeader(matrix, corner);
  for (Eigen::Index row = 0; row < count; ++row) {
    csv += MatrixCsvRow(matrix, row);
  }
  return csv;
}

std::string MatrixCsvHeader(const MatrixView& matrix, std::string_view corner) {
  std::string csv;
  AppendField(corner, csv);
  for (const std::string& label : matrix.labels) {
    csv += ',';
    AppendField(label, csv);
  }
  csv += kLineEnd;
  return csv;
}

std::string MatrixCsvRow(const MatrixView& matrix, Eigen::Index row) {
  std::string csv;
  AppendField(matrix.labels[static_cast<size_t>(row)], csv);
  for (Eigen::Index column = 0; column < matrix.values.cols(); ++column) {
    csv += ',';
    csv += ShortestDecimal(matrix.values(row, column));
  }
  csv += kLineEnd;
  return csv;
}

std::string NeighboursCsv(const MatrixView& matrix,
                          std::span<const std::vector<Neighbour>> neighbours,
                          std::span<const std::string> persons) {
  assert(neighbours.size() == matrix.labels.size());
  assert(persons.empty() || persons.size() == matrix.labels.size());
  const bool has_persons =
      std::any_of(persons.begin(), persons.end(), [](const auto& p) { return !p.empty(); });
  Fields fields = {"mesh", "rank", "neighbour", "value"};
  if (has_persons) AppendNames(std::array{"person", "neighbour_person", "same_person"}, fields);
  std::string csv = CsvRow(fields);
  for (size_t row = 0; row < neighbours.size(); ++row) {
    int64_t rank = 0;
    for (const Neighbour& neighbour : neighbours[row]) {
      const auto column = static_cast<size_t>(neighbour.column);
      fields = {matrix.labels[row], Text(++rank), matrix.labels[column], Text(neighbour.value)};
      if (has_persons) {
        fields.push_back(PersonText(persons[row]));
        fields.push_back(PersonText(persons[column]));
        fields.push_back(SamePersonText(persons[row], persons[column]));
      }
      csv += CsvRow(fields);
    }
  }
  return csv;
}

std::string MeshesCsv(std::span<const JobMesh> meshes,
                      std::span<const MeshAlignment> alignments,
                      std::span<const MeshAlignment> poses) {
  const std::set<std::string> keys = LabelKeys(meshes);
  const std::map<int32_t, const Alignment*> by_mesh = ByMesh(alignments);
  const std::map<int32_t, const Alignment*> pose_of = ByMesh(poses);
  Fields fields;
  AppendNames(kStatusColumns, fields);
  for (const std::string& key : keys) fields.push_back(IsFixedColumn(key) ? "label_" + key : key);
  AppendNames(kFileColumns, fields);
  AppendNames(kHealthColumns, fields);
  AppendNames(kAlignmentColumns, fields);
  AppendNames(kLastColumns, fields);
  std::string csv = CsvRow(fields);
  for (size_t i = 0; i < meshes.size(); ++i) {
    const JobMesh& mesh = meshes[i];
    const auto alignment = by_mesh.find(static_cast<int32_t>(i));
    fields = {mesh.mesh.name, std::string(MeshStatus(mesh)), mesh.rejection};
    AppendLabels(mesh.mesh, keys, fields);
    fields.push_back(mesh.mesh.raw.Hex());
    fields.push_back(Text(mesh.mesh.size_bytes));
    AppendIngested(mesh.ingested, fields);
    AppendAlignment(alignment == by_mesh.end() ? nullptr : alignment->second, fields);
    const auto pose = pose_of.find(static_cast<int32_t>(i));
    fields.push_back(pose == pose_of.end() ? std::string(kMissing)
                                           : Text(pose->second->rms_residual));
    fields.push_back(mesh.copy ? Text(mesh.copy->asymmetry) : std::string(kMissing));
    csv += CsvRow(fields);
  }
  return csv;
}

std::string TransformsCsv(std::span<const JobMesh> meshes,
                          std::span<const MeshAlignment> alignments) {
  Fields fields = {"file", "scale", "r11", "r12", "r13", "r21", "r22", "r23"};
  AppendNames(std::array{"r31", "r32", "r33", "tx", "ty", "tz"}, fields);
  std::string csv = CsvRow(fields);
  for (const auto& [index, alignment] : ByMesh(alignments)) {
    assert(index >= 0 && static_cast<size_t>(index) < meshes.size());
    const Similarity& T = alignment->T_target_source;
    fields = {meshes[static_cast<size_t>(index)].mesh.name, Text(T.scale)};
    for (const double entry : T.rotation.transpose().reshaped()) fields.push_back(Text(entry));
    for (const double entry : T.translation) fields.push_back(Text(entry));
    csv += CsvRow(fields);
  }
  return csv;
}

std::string BaseChoiceCsv(std::span<const JobMesh> meshes, const BaseChoice& choice) {
  std::vector<BaseChoice::Candidate> ranked = choice.candidates;
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.mean_distance < b.mean_distance; });
  std::string csv = "rank,file,mean_distance";
  csv += kLineEnd;
  for (size_t i = 0; i < ranked.size(); ++i) {
    csv += std::to_string(i + 1);
    csv += ',';
    AppendField(meshes[static_cast<size_t>(ranked[i].mesh)].mesh.name, csv);
    csv += ',';
    csv += ShortestDecimal(ranked[i].mean_distance);
    csv += kLineEnd;
  }
  return csv;
}

}  // namespace cohort
