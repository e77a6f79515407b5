// `cohort remeasure`: another matrix of a finished job.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/job_source.h"
#include "client/output/exit_codes.h"
#include "client/remeasure.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/base/version.h"
#include "common/report/csv.h"
#include "common/report/heatmap.h"
#include "common/report/histogram.h"
#include "common/report/job_meshes.h"
#include "common/report/npy.h"

namespace cohort {
namespace {

struct RemeasureFlags {
  JobSource source;
  std::string out;
  std::string metric;
  double lower = 0;
  double upper = 1;
  bool is_signed = false;
  bool by_area = false;
  std::string region;
  std::string symmetrize;
  std::string from = "auto";
  std::optional<int> neighbours;
};

/// What was asked for, checked.
struct Request {
  RemeasureOptions options;
  Symmetrization symmetrization = Symmetrization::kMean;
  int neighbours = 3;
};

absl::StatusOr<Request> MakeRequest(const RemeasureFlags& flags, const JobFrame& frame) {
  const JobSpec& spec = frame.GetJob().spec;
  Request request{.options = {}, .symmetrization = spec.symmetrization};
  request.options.measure.metric = spec.metric;
  if (!flags.metric.empty()) {
    COHORT_ASSIGN_OR_RETURN(request.options.measure, ParseMeasure(flags.metric));
  }
  if (flags.lower >= flags.upper) {
    return absl::InvalidArgumentError(absl::StrCat("--lower ", flags.lower, " --upper ",
                                                   flags.upper,
                                                   ": the lower share must be below the upper"));
  }
  MeasureSpec& measure = request.options.measure;
  measure.lower_share = flags.lower;
  measure.upper_share = flags.upper;
  measure.sign = flags.is_signed ? DistanceSign::kSigned : DistanceSign::kAbsolute;
  measure.by_area = flags.by_area;
  if (!flags.symmetrize.empty()) {
    request.symmetrization = *SymmetrizationFromName(flags.symmetrize);
  }
  for (const MeasureSource source :
       {MeasureSource::kMetrics, MeasureSource::kKept, MeasureSource::kRecompute}) {
    if (MeasureSourceName(source) == flags.from) {
      request.options.source = source;
    }
  }
  if (!flags.region.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(flags.region));
    COHORT_ASSIGN_OR_RETURN(const TriangleMesh mean_shape, frame.LoadMeanShape());
    COHORT_ASSIGN_OR_RETURN(request.options.region,
                            ParseRegionWeights(text, flags.region, mean_shape.VertexCount()));
  }
  request.neighbours = flags.neighbours.value_or(spec.neighbours);
  return request;
}

/// Where the numbers are from and how exact they are, for people.
std::string SourceText(const Remeasured& measured) {
  switch (measured.source) {
    case MeasureSource::kAuto:
    case MeasureSource::kMetrics:
      return "the job's own metrics, exact";
    case MeasureSource::kRecompute:
      return "distances found once more, exact";
    case MeasureSource::kKept:
      break;
  }
  switch (measured.retention) {
    case Retention::kVectors:
      return "kept distances, exact";
    case Retention::kCompact:
      return "kept distances, rounded as the job rounded them (retention compact)";
    default:
      return measured.largest_bound > 0
                 ? absl::StrCat("kept sketches, no value is off by more than ",
                                measured.largest_bound)
                 : "kept sketches, exact for this metric";
  }
}

nlohmann::json ToJson(const Request& request,
                      const JobFrame& frame,
                      const Remeasured& measured,
                      const MatrixDescription& description,
                      const RemeasureFlags& flags) {
  const MeasureSpec& measure = request.options.measure;
  nlohmann::json json = {
      {"software", "cohort " + std::string(BuildVersion())},
      {"job", frame.GetJob().id.value},
      {"meshes", frame.Active().size()},
      {"metric", measure.Name()},
      {"title", measure.Title()},
      {"unit", ValueUnit(description)},
      {"lower", measure.lower_share},
      {"upper", measure.upper_share},
      {"sign", std::string(DistanceSignName(measure.sign))},
      {"by_area", measure.by_area},
      {"region", flags.region.empty() ? nlohmann::json() : nlohmann::json(flags.region)},
      {"symmetrization", std::string(SymmetrizationName(request.symmetrization))},
      {"source", MeasureSourceName(measured.source)},
      {"largest_error", measured.largest_bound},
      {"note", SourceText(measured)},
  };
  if (measured.source == MeasureSource::kKept) {
    json["retention"] = std::string(RetentionName(measured.retention));
  }
  return json;
}

absl::Status WriteFiles(const RemeasureFlags& flags,
                        const Request& request,
                        const JobFrame& frame,
                        const Remeasured& measured,
                        const MatrixDescription& description) {
  MetricMatrix matrix = WithoutRejected(measured.directed, frame.Meshes());
  if (request.symmetrization != Symmetrization::kDirected) {
    matrix = Symmetrized(
        matrix, request.symmetrization == Symmetrization::kMax ? PairRule::kMax : PairRule::kMean);
  }
  const std::vector<std::string> persons = PersonsOf(matrix.labels, frame.Meshes());
  const std::string unit = ValueUnit(description);
  FolderWriter out(flags.out);
  COHORT_RETURN_IF_ERROR(out.Write({"matrix.csv", "value of every pair, with file names", unit},
                                   MatrixCsv(matrix, request.options.measure.Name())));
  COHORT_RETURN_IF_ERROR(
      out.Write({"matrix.npy", "matrix.csv for NumPy", unit}, MatrixNpy(matrix.values)));
  COHORT_RETURN_IF_ERROR(out.Write({"labels.txt", "file names of the rows of matrix.npy", ""},
                                   LabelsText(matrix.labels)));
  if (description.sign == DistanceSign::kAbsolute) {
    const auto nearest = NearestNeighbours(matrix, request.neighbours);
    COHORT_RETURN_IF_ERROR(
        out.Write({"neighbours.csv", "the most similar meshes of each mesh", unit},
                  NeighboursCsv(matrix, nearest, persons)));
  } else {
    out.LeaveOut("neighbours.csv");  // Of signed distances the smallest is not the most similar.
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"heatmap.png", "the matrix as a picture", unit}, HeatmapPng(matrix, description)));
  COHORT_RETURN_IF_ERROR(out.Write({"histogram.png", "distribution of the pairs", unit},
                                   HistogramPng(matrix, description, persons)));
  return out.Write({"remeasure.json", "what was asked for, and how exact it is", ""},
                   ToJson(request, frame, measured, description, flags).dump(2) + "\n");
}

absl::StatusOr<int> RunRemeasure(const RemeasureFlags& flags) {
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  COHORT_ASSIGN_OR_RETURN(const OpenedJob opened, flags.source.Open());
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(*opened.session, opened.Blobs(), opened.id));
  COHORT_ASSIGN_OR_RETURN(const Request request, MakeRequest(flags, *frame));
  ThreadPool threads(LocalThreads());
  COHORT_ASSIGN_OR_RETURN(const Remeasured measured,
                          Remeasure(*opened.session, *frame, request.options, threads));
  const JobSpec& spec = frame->GetJob().spec;
  const MatrixDescription description{.metric = request.options.measure.metric,
                                      .method = spec.method,
                                      .symmetrization = request.symmetrization,
                                      .arithmetic = spec.arithmetic,
                                      .sign = request.options.measure.sign,
                                      .title = request.options.measure.Title()};
  COHORT_RETURN_IF_ERROR(WriteFiles(flags, request, *frame, measured, description));
  if (flags.source.server.json) {
    std::cout << ToJson(request, *frame, measured, description, flags).dump(2) << "\n";
  } else {
    std::cout << request.options.measure.Title() << " of " << frame->Active().size()
              << " meshes of job " << opened.id.value << "\n  from " << SourceText(measured)
              << "\n  " << (std::filesystem::path(flags.out) / "matrix.csv").string() << "\n";
  }
  return kExitOk;
}

}  // namespace

void AddRemeasureCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "remeasure", "another matrix of a finished job, from what it kept of its distances");
  const auto flags = std::make_shared<RemeasureFlags>();
  flags->source.AddTo(*command);
  command->add_option("--out", flags->out, "folder for the matrix; made if new")->required();
  command->add_option("--metric", flags->metric,
                      "rms, mean, geometric-mean, min, max, variance, or a percentile: p95; else "
                      "the job's");
  command->add_option("--lower", flags->lower, "distances below this share of them do not count")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--upper", flags->upper, "distances above this share of them do not count")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_flag("--signed", flags->is_signed,
                    "positive in front of the target, negative behind it");
  command->add_flag(
      "--by-area", flags->by_area,
      "vertices count by the surface they stand for, so that density does not matter");
  command->add_option("--region", flags->region,
                      "text file with a weight >= 0 per vertex of mean_shape.ply, one a line: what "
                      "counts of every mesh");
  command->add_option("--symmetrize", flags->symmetrize, "mean, max, directed; else the job's")
      ->check(CLI::IsMember({"mean", "max", "directed"}));
  command
      ->add_option("--source", flags->from,
                   "metrics: the seven that every job has; kept: kept distances; recompute: "
                   "find the distances once more on this machine; auto: the first that can")
      ->check(CLI::IsMember({"auto", "metrics", "kept", "recompute"}))
      ->capture_default_str();
  command->add_option("--neighbours", flags->neighbours, "most similar meshes listed per mesh")
      ->check(CLI::Range(1, 1'000'000));
  command->callback([flags, &action] { action = [flags] { return RunRemeasure(*flags); }; });
  command->footer(
      "Nothing of the job changes. From sketches, percentiles and thresholds have a small error,\n"
      "which is stated; --source recompute is exact.\n"
      "Examples: cohort remeasure j-000001 --metric p95 --out p95\n"
      "          cohort remeasure results --upper 0.9 --by-area --out trimmed");
}

}  // namespace cohort
