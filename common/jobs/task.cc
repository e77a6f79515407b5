#include "common/jobs/task.h"

#include <absl/strings/escaping.h>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/jobs/json_fields.h"

namespace cohort {
namespace {

using nlohmann::json;

json ToJson(const WorkCounters& counters) {
  return {{"index_builds", counters.index_builds}, {"lookups", counters.lookups}};
}

json ToJson(const IngestedMesh& mesh) {
  return {{"index", mesh.index}, {"blob", mesh.blob.Hex()},   {"vertices", mesh.vertices},
          {"faces", mesh.faces}, {"centroid", mesh.centroid}, {"health", ToJson(mesh.health)}};
}

json ToJson(const MeshRejection& rejection) {
  return {{"index", rejection.index}, {"reason", rejection.reason}};
}

void ReadWorkCounters(JsonFields& fields, std::string_view key, WorkCounters& counters) {
  fields.ReadObject(key, [&counters](JsonFields& work) {
    work.Read("index_builds", counters.index_builds);
    work.Read("lookups", counters.lookups);
  });
}

void ReadCounters(JsonFields& fields, Counters& counters) {
  ReadWorkCounters(fields, "pose", counters.pose);
  ReadWorkCounters(fields, "align", counters.align);
  ReadWorkCounters(fields, "average", counters.average);
  ReadWorkCounters(fields, "compare", counters.compare);
  ReadWorkCounters(fields, "variation", counters.variation);
  fields.Read("pairs", counters.pairs);
}

void ReadHealth(JsonFields& fields, MeshHealth& health) {
  fields.Read("vertices", health.vertices);
  fields.Read("faces", health.faces);
  fields.Read("duplicate_vertices", health.duplicate_vertices);
  fields.Read("unreferenced_vertices", health.unreferenced_vertices);
  fields.Read("degenerate_faces", health.degenerate_faces);
  fields.Read("duplicate_faces", health.duplicate_faces);
  fields.Read("non_manifold_edges", health.non_manifold_edges);
  fields.Read("components", health.components);
  fields.Read("largest_component_share", health.largest_component_share);
  fields.Read("boundary_share", health.boundary_share);
  fields.Read("diagonal", health.diagonal);
  fields.Read("rms_radius", health.rms_radius);
  fields.Read("surface_area", health.surface_area);
  fields.Read("point_cloud", health.point_cloud);
  fields.Read("warnings", health.warnings);
}

void ReadIngested(JsonFields& fields, IngestedMesh& mesh) {
  fields.Read("index", mesh.index);
  fields.Read("blob", mesh.blob);
  fields.Read("vertices", mesh.vertices);
  fields.Read("faces", mesh.faces);
  fields.Read("centroid", mesh.centroid);
  fields.ReadObject("health", [&mesh](JsonFields& health) { ReadHealth(health, mesh.health); });
}

}  // namespace

std::string_view TaskKindName(TaskKind kind) {
  switch (kind) {
    case TaskKind::kIngest:
      return "ingest";
    case TaskKind::kPose:
      return "pose";
    case TaskKind::kAlign:
      return "align";
    case TaskKind::kAverage:
      return "average";
    case TaskKind::kCompare:
      return "compare";
    case TaskKind::kAlignAndCompare:
      return "align-and-compare";
    case TaskKind::kVariation:
      return "variation";
    case TaskKind::kSummarize:
      return "summarize";
    case TaskKind::kPreview:
      return "preview";
    case TaskKind::kChooseBase:
      return "choose-base";
    case TaskKind::kSymmetrize:
      return "symmetrize";
  }
  return "unknown";
}

Counters& Counters::operator+=(const Counters& other) {
  pose += other.pose;
  align += other.align;
  average += other.average;
  compare += other.compare;
  variation += other.variation;
  pairs += other.pairs;
  return *this;
}

json ToJson(const MeshHealth& health) {
  return {{"vertices", health.vertices},
          {"faces", health.faces},
          {"duplicate_vertices", health.duplicate_vertices},
          {"unreferenced_vertices", health.unreferenced_vertices},
          {"degenerate_faces", health.degenerate_faces},
          {"duplicate_faces", health.duplicate_faces},
          {"non_manifold_edges", health.non_manifold_edges},
          {"components", health.components},
          {"largest_component_share", health.largest_component_share},
          {"boundary_share", health.boundary_share},
          {"diagonal", health.diagonal},
          {"rms_radius", health.rms_radius},
          {"surface_area", health.surface_area},
          {"point_cloud", health.point_cloud},
          {"warnings", health.warnings}};
}

json ToJson(const Counters& counters) {
  return {{"pose", ToJson(counters.pose)},           {"align", ToJson(counters.align)},
          {"average", ToJson(counters.average)},     {"compare", ToJson(counters.compare)},
          {"variation", ToJson(counters.variation)}, {"pairs", counters.pairs}};
}

json ToJson(const TaskResult& result) {
  json ingested = json::array();
  for (const IngestedMesh& mesh : result.ingested) {
    ingested.push_back(ToJson(mesh));
  }
  json copies = json::array();
  for (const SymmetricCopy& copy : result.copies) {
    copies.push_back(
        {{"index", copy.index}, {"blob", copy.blob.Hex()}, {"asymmetry", copy.asymmetry}});
  }
  json rejections = json::array();
  for (const MeshRejection& rejection : result.rejections) {
    rejections.push_back(ToJson(rejection));
  }
  return {{"output", result.output.Hex()},
          {"alignments", absl::Base64Escape(result.alignments)},
          {"second_output", result.second_output.Hex()},
          {"poses", result.poses.Hex()},
          {"variation", result.variation.Hex()},
          {"ingested", std::move(ingested)},
          {"copies", std::move(copies)},
          {"rejections", std::move(rejections)},
          {"counters", ToJson(result.counters)},
          {"seconds", result.seconds},
          {"placed", result.placed.Hex()},
          {"fields", result.fields.Hex()},
          {"change", result.change},
          {"base", result.base}};
}

absl::StatusOr<TaskResult> TaskResultFromJson(const json& json) {
  TaskResult result;
  JsonFields fields(json, "task result", absl::StatusCode::kDataLoss, Presence::kOptional);
  fields.Read("output", result.output);
  fields.ReadBase64("alignments", result.alignments);
  fields.Read("second_output", result.second_output);
  fields.Read("poses", result.poses);
  fields.Read("variation", result.variation);
  fields.ReadObjects("ingested", [&result](JsonFields& mesh) {
    ReadIngested(mesh, result.ingested.emplace_back());
  });
  fields.ReadObjects("copies", [&result](JsonFields& item) {
    SymmetricCopy& copy = result.copies.emplace_back();
    item.Read("index", copy.index);
    item.Read("blob", copy.blob);
    item.Read("asymmetry", copy.asymmetry);
  });
  fields.ReadObjects("rejections", [&result](JsonFields& item) {
    MeshRejection& rejection = result.rejections.emplace_back();
    item.Read("index", rejection.index);
    item.Read("reason", rejection.reason);
  });
  fields.ReadObject("counters",
                    [&result](JsonFields& counters) { ReadCounters(counters, result.counters); });
  fields.Read("seconds", result.seconds);
  fields.Read("placed", result.placed);
  fields.Read("fields", result.fields);
  fields.Read("change", result.change);
  fields.Read("base", result.base);
  COHORT_RETURN_IF_ERROR(fields.Finish());
  return result;
}

}  // namespace cohort
