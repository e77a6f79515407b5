#include "client/evaluation/lab.h"

#include <algorithm>

#include <absl/strings/str_cat.h>

#include "client/fetched_matrix.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr double kStartSeconds = 30;
double SecondsOf(const Job& job) {
  int64_t milliseconds = 0;
  for (const StageTime& stage : job.progress.stages) {
    // The first alignment finds the poses too; method each does so before.
    const bool counts = stage.name.starts_with("align") || stage.name.starts_with("average") ||
                        stage.name == "pose" ||
                        (job.spec.method == Method::kEach && stage.name == "compare");
    milliseconds += counts ? stage.finished_unix_ms - stage.started_unix_ms : 0;
  }
  return static_cast<double>(milliseconds) / 1000;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Lab>> Lab::Start(const std::filesystem::path& data, int workers) {
  std::unique_ptr<Lab> lab(new Lab);
  COHORT_ASSIGN_OR_RETURN(lab->cluster_,
                          LocalCluster::Start({.data_dir = data,
                                               .workers = workers,
                                               .threads = 1,
                                               .on_failure = EndProgramOnFailure(data)}));
  COHORT_ASSIGN_OR_RETURN(lab->session_, Session::Open(lab->cluster_->Address()));
  COHORT_RETURN_IF_ERROR(lab->session_->WaitUntilReady(kStartSeconds));
  return lab;
}

absl::Status Lab::AddSet(const std::string& set, const std::vector<MeshFile>& files) {
  return Upload(*session_, set, files).status();
}

absl::StatusOr<Experiment> Lab::Run(const std::string& set, JobSpec spec, Timing timing) {
  spec.compare.retention = Retention::kMetrics;
  spec.fresh = timing == Timing::kTimed;
  Experiment experiment;
  COHORT_ASSIGN_OR_RETURN(const Job created, session_->CreateJob(set, spec, ""));
  COHORT_ASSIGN_OR_RETURN(experiment.job,
                          session_->WatchJob(created.id, [](const Job&) { return true; }));
  const std::string name =
      absl::StrCat("set ", set, ", method ", std::string(MethodName(spec.method)));
  if (experiment.job.state != JobState::kSucceeded) {
    return absl::FailedPreconditionError(absl::StrCat(name, ": ", experiment.job.error));
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes, session_->ListJobMeshes(created.id));
  for (const JobMesh& mesh : meshes) {
    if (!mesh.rejection.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(name, ": ", mesh.mesh.name,
                       " was rejected, take it out of the folder: ", mesh.rejection));
    }
    experiment.vertices.push_back(mesh.ingested->vertices);
  }
  experiment.seconds = SecondsOf(experiment.job);
  COHORT_ASSIGN_OR_RETURN(experiment.rms, Matrix(experiment, Metric::kRms));
  return experiment;
}

absl::StatusOr<MetricMatrix> Lab::Matrix(const Experiment& experiment, Metric metric) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes,
                          session_->ListJobMeshes(experiment.job.id));
  COHORT_ASSIGN_OR_RETURN(const LargeMatrix directed,
                          FetchMatrix(*session_, experiment.job.id, metric, meshes));
  return Symmetrized(directed.View(), PairRule::kMean);
}

JobSpec ThesisSpec(Method method, int iterations, double tolerance, int rounds) {
  JobSpec spec = PresetSpec("thesis", method).value();
  spec.rounds = rounds;
  spec.icp.max_iterations = method == Method::kAverage ? iterations / (rounds + 1) : iterations;
  spec.icp.tolerance = tolerance;
  return spec;
}

}  // namespace cohort
