#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/local_cluster.h"
#include "client/session.h"
#include "client/upload.h"
#include "common/analysis/metric_matrix.h"
#include "common/jobs/job_spec.h"

namespace cohort {

/// One job of an evaluation, finished.
struct Experiment {
  Job job;
  MetricMatrix rms;               ///< Mean of both directions.
  std::vector<int64_t> vertices;  ///< Of each canonical mesh.
  /// Of the stages that align and average (of method each, whose tasks also compare, all of them):
  /// what the thesis's times are of.
  double seconds = 0;

  /// As the thesis counts (tables 5.4, 5.5): alignment and averaging, not the comparison.
  [[nodiscard]] WorkCounters ThesisCounters() const {
    WorkCounters counters = job.counters.align;
    counters += job.counters.average;
    return counters;
  }
};

/// Whether the time of an experiment is asked for: then nothing known from earlier ones is used.
enum class Timing { kAnyTime, kTimed };

/// Runs jobs on this machine, one after the other.
class Lab {
 public:
  /// @param workers  each with one thread.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Lab>> Start(const std::filesystem::path& data,
                                                                  int workers);

  [[nodiscard]] absl::Status AddSet(const std::string& set, const std::vector<MeshFile>& files);
  /// @return the job's error if it fails; kFailedPrecondition if a mesh was rejected, naming it.
  [[nodiscard]] absl::StatusOr<Experiment> Run(const std::string& set, JobSpec spec, Timing timing);
  /// Another metric of an experiment, mean of both directions.
  [[nodiscard]] absl::StatusOr<MetricMatrix> Matrix(const Experiment& experiment, Metric metric);
  [[nodiscard]] Session& GetSession() { return *session_; }

 private:
  Lab() = default;

  std::unique_ptr<LocalCluster> cluster_;
  std::unique_ptr<Session> session_;
};

/// The thesis's parameters: at most `iterations` a mesh, to Average spread over its rounds and the
/// last alignment: iterations / (rounds + 1) each.
/// @param tolerance  mm; 0: all iterations run.
[[nodiscard]] JobSpec ThesisSpec(Method method, int iterations, double tolerance, int rounds = 3);

}  // namespace cohort
