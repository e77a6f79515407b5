// What a job would take, and whether there is room for it.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <absl/strings/str_format.h>
#include <nlohmann/json.hpp>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

/// The size of a file tells the number of its vertices to this factor at worst.
constexpr double kFileSizeDoubt = 8;
constexpr int kJobsPerPage = 1000;
constexpr double kGigabyte = 1e9;

double BytesWritten(const JobForecast& forecast, Retention retention) {
  return forecast.other_bytes + forecast.distance_bytes.at(retention);
}

/// Equal for specs of the same results.
nlohmann::json ResultsOf(JobSpec spec) {
  spec.priority = 0;
  spec.fresh = false;
  return ToJson(spec);
}

absl::Status TooSmall(const JobForecast& forecast, const JobSpec& spec, double free) {
  const Retention chosen = forecast.retention;
  std::string text = absl::StrFormat(
      "the job would write %.2f GB (distances of %d pairs with retention %s: %.2f GB; all else: "
      "%.2f GB), the server's store has room for %.2f GB: ",
      BytesWritten(forecast, chosen) / kGigabyte, forecast.pairs,
      std::string(RetentionName(chosen)), forecast.distance_bytes.at(chosen) / kGigabyte,
      forecast.other_bytes / kGigabyte, free / kGigabyte);
  for (const Retention poorer : {Retention::kCompact, Retention::kSketch, Retention::kMetrics}) {
    const bool is_smaller = forecast.distance_bytes.at(poorer) < forecast.distance_bytes.at(chosen);
    const bool is_allowed =
        spec.arithmetic != Arithmetic::kFidentis || poorer == Retention::kMetrics;
    if (is_smaller && is_allowed && BytesWritten(forecast, poorer) <= free) {
      absl::StrAppendFormat(&text, "--retention %s would fit (%.2f GB); ",
                            std::string(RetentionName(poorer)),
                            BytesWritten(forecast, poorer) / kGigabyte);
    }
  }
  return WithReason(
      absl::ResourceExhaustedError(text + "or make space (delete jobs and sets, cohort gc)"),
      "STORE_TOO_SMALL");
}

}  // namespace

absl::StatusOr<JobForecast> Coordinator::ForecastJob(const JobSpec& spec,
                                                     const std::vector<SetMesh>& meshes,
                                                     const JobOutputs& kept) {
  std::vector<IngestedMesh> known;
  for (size_t i = 0; i < meshes.size(); ++i) {
    COHORT_ASSIGN_OR_RETURN(std::optional<IngestedMesh> mesh,
                            catalog_.FindIngested(meshes[i].raw, spec.position_bits));
    if (mesh) {
      mesh->index = static_cast<int32_t>(i);
      known.push_back(*std::move(mesh));
    }
  }
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<JobPlan> plan,
                          JobPlan::Create(spec, meshes, known, kept));
  return plan->Forecast();
}

absl::StatusOr<Estimate> Coordinator::EstimateOver(const JobSpec& spec,
                                                   const std::vector<SetMesh>& meshes) {
  JobSpec complete = spec;
  JobOutputs kept;
  if (!spec.reference_job.empty()) {
    COHORT_ASSIGN_OR_RETURN(ReferenceFrame frame, FrameFor(spec, meshes));
    complete = std::move(frame.spec);
    kept = std::move(frame.kept);
  }
  COHORT_ASSIGN_OR_RETURN(const JobForecast forecast, ForecastJob(complete, meshes, kept));
  Estimate estimate;
  estimate.meshes = forecast.meshes;
  estimate.pairs = forecast.pairs;
  estimate.retention = forecast.retention;
  for (const auto& [retention, bytes] : forecast.distance_bytes) {
    estimate.distance_bytes[retention] = static_cast<int64_t>(bytes);
  }
  estimate.other_bytes = static_cast<int64_t>(forecast.other_bytes);
  estimate.slots = static_cast<int>(Figures().slots);
  const MutexLock lock(mutex_);
  for (const StageForecast& stage : forecast.stages) {
    const std::optional<double> rate = rates_.RateOf(TaskRates::KindOf(complete, stage.name));
    const double seconds = stage.cost * rate.value_or(1);
    estimate.stages.push_back({.name = stage.name,
                               .tasks = stage.tasks,
                               .core_seconds = seconds,
                               .is_measured = rate.has_value()});
    if (estimate.slots > 0) {
      // A stage ends with its last task.
      estimate.wall_seconds += std::max(seconds / estimate.slots, stage.longest * rate.value_or(1));
    }
  }
  return estimate;
}

absl::StatusOr<Estimate> Coordinator::EstimateJob(const std::string& set, const JobSpec& spec) {
  COHORT_RETURN_IF_ERROR(spec.Validate());
  COHORT_ASSIGN_OR_RETURN(const std::vector<SetMesh> meshes, AllMeshes(set));
  COHORT_ASSIGN_OR_RETURN(Estimate estimate, EstimateOver(spec, meshes));
  if (const absl::StatusOr<StoreSpace> space = store_.Space(); space.ok()) {
    estimate.free_bytes = options_.reserve.Available(*space);
  }
  if (spec.method == Method::kEach) {
    JobSpec average = spec;
    average.method = Method::kAverage;
    const absl::StatusOr<Estimate> other = EstimateOver(average, meshes);
    estimate.average_core_seconds = other.ok() ? other->CoreSeconds() : 0;
  }
  return estimate;
}

absl::Status Coordinator::CheckRoom(const JobRequest& request,
                                    const std::vector<SetMesh>& meshes,
                                    const JobOutputs& kept,
                                    const JobForecast& rough) {
  COHORT_ASSIGN_OR_RETURN(const StoreSpace space, store_.Space());
  const auto free = static_cast<double>(options_.reserve.Available(space));
  if (kFileSizeDoubt * BytesWritten(rough, rough.retention) <= free) {
    return absl::OkStatus();
  }
  const absl::StatusOr<JobForecast> forecast = ForecastJob(request.spec, meshes, kept);
  // A job that cannot go on with these meshes says so itself.
  if (!forecast.ok() || BytesWritten(*forecast, forecast->retention) <= free) {
    return absl::OkStatus();
  }
  COHORT_ASSIGN_OR_RETURN(const bool is_there, WritesNothingNew(request));
  return is_there ? absl::OkStatus() : TooSmall(*forecast, request.spec, free);
}

absl::StatusOr<bool> Coordinator::WritesNothingNew(const JobRequest& request) {
  COHORT_ASSIGN_OR_RETURN(const std::optional<Job> same,
                          catalog_.FindJobOfRequest(request.request_id));
  if (same || request.spec.fresh) {
    return same.has_value();
  }
  const nlohmann::json wanted = ResultsOf(request.spec);
  std::string token;
  do {
    COHORT_ASSIGN_OR_RETURN(const Page<Job> page, catalog_.ListJobs(kJobsPerPage, token));
    if (std::any_of(page.items.begin(), page.items.end(), [&](const Job& job) {
          return job.state == JobState::kSucceeded && job.set == request.set &&
                 ResultsOf(job.spec) == wanted;
        })) {
      return true;
    }
    token = page.next_token;
  } while (!token.empty());
  return false;
}

}  // namespace cohort
