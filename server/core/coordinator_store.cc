// What the coordinator does about little space and garbage in its store.
#include <string>

#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {

absl::Status Coordinator::CheckSpace() {
  COHORT_ASSIGN_OR_RETURN(const StoreSpace space, store_.Space());
  return options_.reserve.Check(space);
}

void Coordinator::NoteSpace(const absl::Status& space) {
  if (no_space_.empty() != space.ok()) {
    no_space_ = std::string(space.message());
    if (space.ok()) {
      spdlog::info("event=space_again");
    } else {
      spdlog::error("event=no_space error=\"{}\"", no_space_);
    }
  }
  for (auto& [id, active] : active_) {
    if (!IsFinal(active.job.state) && active.job.progress.waiting_for != no_space_) {
      active.job.progress.waiting_for = no_space_;
      Touch(active);
    }
  }
}

absl::StatusOr<GarbageCount> Coordinator::CollectGarbage(const GarbageOptions& options,
                                                         const std::stop_token& stop) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  {
    // Not while a job takes up a remembered result: until it is the job's own, only this row keeps
    // its blobs.
    const MutexLock lock(mutex_);
    const double before = static_cast<double>(WallMs()) - options.remember_seconds * 1000;
    COHORT_ASSIGN_OR_RETURN(const int64_t forgotten,
                            catalog_.ForgetActions(before > 0 ? static_cast<int64_t>(before) : 0));
    COHORT_ASSIGN_OR_RETURN(const int64_t forgotten_meshes, catalog_.ForgetUnusedIngested());
    spdlog::info("event=results_forgotten tasks={} meshes={}", forgotten, forgotten_meshes);
  }
  COHORT_ASSIGN_OR_RETURN(const GarbageCount count,
                          cohort::CollectGarbage(catalog_, store_, options.age_seconds, stop));
  spdlog::info("event=garbage_collected blobs={} bytes={} kept_blobs={} kept_bytes={}", count.blobs,
               count.bytes, count.kept_blobs, count.kept_bytes);
  return count;
}

}  // namespace cohort
