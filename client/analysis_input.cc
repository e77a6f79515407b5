#include "client/analysis_input.h"

#include <charconv>
#include <filesystem>
#include <memory>
#include <utility>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "client/fetched_matrix.h"
#include "client/files.h"
#include "client/matrix_files.h"
#include "client/session.h"
#include "common/analysis/distances.h"
#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "common/report/job_meshes.h"
#include "common/report/matrix_description.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

absl::Status In(const std::string& source, const absl::Status& status) {
  return status.ok() ? status
                     : absl::Status(status.code(),
                                    absl::StrCat(source, ": ", std::string(status.message())));
}

absl::Status RequireUnsigned(DistanceSign sign) {
  return sign == DistanceSign::kAbsolute
             ? absl::OkStatus()
             : absl::FailedPreconditionError(
                   "the distances are signed: the smallest is not the most similar; run the job "
                   "with absolute ones");
}

/// What the matrix of a job means.
struct MatrixMeaning {
  std::string metric;
  std::string unit;
  Symmetrization symmetrization = Symmetrization::kMean;
  DistanceSign sign = DistanceSign::kAbsolute;
};

/// @param directed  a job's own matrix; folders hold what its rule has made of it.
void Symmetrize(const AnalysisSource& source, AnalysisInput& input) {
  if (source.symmetrize) {
    input.matrix = Symmetrized(input.matrix, *source.symmetrize);
    return;
  }
  input.matrix = Symmetrized(input.matrix, PairRule::kMean);
  input.notes.push_back(
      "the matrix is directed: the mean of both directions stands for each pair (--symmetrize)");
}

/// A member that is text; empty if there is none.
std::string TextOf(const Json& object, const char* key) {
  return object.is_object() && object.contains(key) && object[key].is_string()
             ? object[key].get<std::string>()
             : std::string();
}

absl::StatusOr<Json> ReadJson(const fs::path& file) {
  COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(file));
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) {
    return absl::InvalidArgumentError(file.string() + ": is not JSON");
  }
  return json;
}

/// @return kInvalidArgument if a name is not known.
absl::StatusOr<MatrixMeaning> MeaningOf(const fs::path& file,
                                        const std::string& symmetrization,
                                        const std::string& sign) {
  const auto rule = SymmetrizationFromName(symmetrization);
  const auto its_sign = DistanceSignFromName(sign);
  if (!rule || !its_sign) {
    return absl::InvalidArgumentError(file.string() + ": symmetrization or sign are not known");
  }
  MatrixMeaning meaning;
  meaning.symmetrization = *rule;
  meaning.sign = *its_sign;
  return meaning;
}

/// What `cohort remeasure` says of its matrix.
absl::StatusOr<std::optional<MatrixMeaning>> ReadRemeasureFile(const fs::path& file) {
  COHORT_ASSIGN_OR_RETURN(const Json json, ReadJson(file));
  COHORT_ASSIGN_OR_RETURN(MatrixMeaning meaning,
                          MeaningOf(file, TextOf(json, "symmetrization"), TextOf(json, "sign")));
  meaning.metric = TextOf(json, "metric");
  meaning.unit = TextOf(json, "unit");
  return std::optional<MatrixMeaning>(meaning);
}

/// Reads job.json of a results folder. Other programs may have changed it, so nothing is taken for
/// granted.
/// @return empty if it says nothing of a metric (cohort gpa).
absl::StatusOr<std::optional<MatrixMeaning>> ReadJobFile(const fs::path& file,
                                                         AnalysisInput& input) {
  COHORT_ASSIGN_OR_RETURN(const Json job, ReadJson(file));
  for (const Json& mesh : job.value("meshes", Json::array())) {
    if (!mesh.is_object() || !mesh.contains("name") || !mesh["name"].is_string()) {
      return absl::InvalidArgumentError(file.string() + ": a mesh has no name");
    }
    const std::string name = mesh["name"].get<std::string>();
    if (mesh.contains("reason")) {
      input.rejected.push_back(name);
    }
    const Json labels = mesh.value("labels", Json::object());
    for (const auto& [key, value] : labels.items()) {
      input.labels[name][key] = value.is_string() ? value.get<std::string>() : value.dump();
    }
  }
  const Json parameters = job.value("parameters", Json::object());
  if (!parameters.is_object() || !parameters.contains("metric")) {
    return std::optional<MatrixMeaning>();
  }
  const auto metric = MetricFromName(TextOf(parameters, "metric"));
  if (!metric) {
    return absl::InvalidArgumentError(file.string() + ": the metric is not known");
  }
  COHORT_ASSIGN_OR_RETURN(MatrixMeaning meaning,
                          MeaningOf(file, TextOf(parameters, "symmetrization"),
                                    TextOf(parameters.value("compare", Json::object()), "sign")));
  meaning.metric = std::string(MetricName(*metric));
  meaning.unit = ValueUnit({.metric = *metric});
  return std::optional<MatrixMeaning>(meaning);
}

/// Residuals of meshes.csv.
absl::Status ReadMeshesFile(const fs::path& file, AnalysisInput& input) {
  COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(file));
  COHORT_ASSIGN_OR_RETURN(const Labels rows, ParseLabels(text, file.string()));
  for (const auto& [mesh, columns] : rows) {
    const auto column = columns.find("rms_residual");
    double residual = 0;
    if (column != columns.end()) {
      const std::string& field = column->second;
      const char* end = field.data() + field.size();
      if (std::from_chars(field.data(), end, residual).ptr == end && !field.empty()) {
        input.residuals[mesh] = residual;
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<AnalysisInput> ReadFolder(const AnalysisSource& source) {
  const fs::path folder(source.source);
  AnalysisInput input;
  input.source = source.source;
  const bool has_numbers = fs::exists(folder / "matrix.npy") && fs::exists(folder / "labels.txt");
  if (!has_numbers && !fs::exists(folder / "matrix.csv")) {
    return absl::NotFoundError("has no matrix.npy and labels.txt, and no matrix.csv");
  }
  COHORT_ASSIGN_OR_RETURN(input.matrix,
                          ReadMatrixFile(folder / (has_numbers ? "matrix.npy" : "matrix.csv")));
  std::optional<MatrixMeaning> meaning;
  if (fs::exists(folder / "job.json")) {
    COHORT_ASSIGN_OR_RETURN(meaning, ReadJobFile(folder / "job.json", input));
  } else if (fs::exists(folder / "remeasure.json")) {
    COHORT_ASSIGN_OR_RETURN(meaning, ReadRemeasureFile(folder / "remeasure.json"));
  }
  if (meaning) {
    COHORT_RETURN_IF_ERROR(RequireUnsigned(meaning->sign));
    input.metric = meaning->metric;
    input.unit = meaning->unit;
  }
  if (source.metric && (!meaning || meaning->metric != MetricName(*source.metric))) {
    const std::string metric(MetricName(*source.metric));
    return absl::FailedPreconditionError(
        absl::StrCat("holds ", meaning ? input.metric : "another metric", ", not ", metric,
                     "; write another folder: cohort results JOB --metric ", metric, " --out DIR"));
  }
  if (fs::exists(folder / "meshes.csv")) {
    COHORT_RETURN_IF_ERROR(ReadMeshesFile(folder / "meshes.csv", input));
  }
  if (source.symmetrize || (meaning && meaning->symmetrization == Symmetrization::kDirected)) {
    Symmetrize(source, input);
  }
  return input;
}

absl::StatusOr<AnalysisInput> ReadFile(const AnalysisSource& source) {
  if (source.metric) {
    return absl::FailedPreconditionError(
        "is a matrix file, whose metric is what it is: leave --metric out");
  }
  AnalysisInput input;
  input.source = source.source;
  COHORT_ASSIGN_OR_RETURN(input.matrix, ReadMatrixFile(source.source));
  if (source.symmetrize) {
    Symmetrize(source, input);
  }
  return input;
}

absl::Status FetchResiduals(Session& session,
                            const JobId& id,
                            const std::vector<JobMesh>& meshes,
                            AnalysisInput& input) {
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, session.GetOutputs(id));
  for (const Digest& blob : outputs.alignments) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(blob));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> some, DecodeAlignmentBlob(bytes));
    for (const MeshAlignment& one : some) {
      input.residuals[meshes[static_cast<size_t>(one.mesh)].mesh.name] = one.alignment.rms_residual;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<AnalysisInput> FetchJob(const AnalysisSource& source) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(source.server));
  const JobId id{source.source};
  COHORT_ASSIGN_OR_RETURN(const Job job, session->GetJob(id));
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes, session->ListJobMeshes(id));
  COHORT_RETURN_IF_ERROR(RequireUnsigned(job.spec.compare.sign));
  const Metric metric = source.metric.value_or(job.spec.metric);
  COHORT_ASSIGN_OR_RETURN(const LargeMatrix directed, FetchMatrix(*session, id, metric, meshes));
  AnalysisInput input;
  input.source = source.source;
  input.matrix = {directed.Labels(), directed.View().values};
  input.metric = std::string(MetricName(metric));
  input.unit = ValueUnit({.metric = metric});
  if (source.symmetrize || job.spec.symmetrization == Symmetrization::kDirected) {
    Symmetrize(source, input);
  } else {
    input.matrix = Symmetrized(input.matrix, job.spec.symmetrization == Symmetrization::kMax
                                                 ? PairRule::kMax
                                                 : PairRule::kMean);
  }
  for (const JobMesh& mesh : meshes) {
    input.labels[mesh.mesh.name] = mesh.mesh.labels;
    if (!mesh.rejection.empty()) {
      input.rejected.push_back(mesh.mesh.name);
    }
  }
  COHORT_RETURN_IF_ERROR(FetchResiduals(*session, id, meshes, input));
  return input;
}

bool LooksLikeAJob(const std::string& source) {
  return source.size() > 2 && source.starts_with("j-") &&
         source.find_first_not_of("0123456789", 2) == std::string::npos;
}

absl::StatusOr<AnalysisInput> ReadAny(const AnalysisSource& source) {
  std::error_code unknown;
  if (fs::is_directory(source.source, unknown)) {
    return ReadFolder(source);
  }
  if (fs::exists(source.source, unknown)) {
    return ReadFile(source);
  }
  if (LooksLikeAJob(source.source)) {
    return FetchJob(source);
  }
  return absl::NotFoundError("no such folder or matrix file, and not the id of a job (j-000001)");
}

}  // namespace

absl::StatusOr<AnalysisInput> ReadAnalysisInput(const AnalysisSource& source) {
  absl::StatusOr<AnalysisInput> input = ReadAny(source);
  if (!input.ok()) {
    // The readers of files name them, with the folder.
    return std::string(input.status().message()).starts_with(source.source)
               ? input.status()
               : In(source.source, input.status());
  }
  absl::Status usable = RequireSymmetric(input->matrix, 3);
  if (!usable.ok() && std::string(usable.message()).find("not symmetric") != std::string::npos) {
    usable = absl::Status(usable.code(), absl::StrCat(std::string(usable.message()),
                                                      "; --symmetrize mean or max makes it so"));
  }
  COHORT_RETURN_IF_ERROR(In(source.source, usable));
  return input;
}

}  // namespace cohort
