#include "client/output/job_pace.h"

namespace cohort {
namespace {

/// Before so much of the work is done, its pace says little about the rest.
constexpr double kTellingShare = 0.05;

bool IsHeld(const Job& job) {
  return job.state != JobState::kRunning || !job.progress.waiting_for.empty();
}

}  // namespace

void JobPace::Note(const Job& job, double elapsed_seconds, int64_t now_unix_ms) {
  last_ = {.elapsed_seconds = elapsed_seconds,
           .cost_done = job.progress.cost_done,
           .tasks_done = job.progress.tasks_done};
  const bool was_held = first_ && IsHeld(job_);
  // Damage can put a job back.
  const bool is_back = first_ && last_.cost_done < first_->cost_done;
  if (!first_ || was_held || is_back) {
    age_tells_ = age_tells_ && (!was_held || job_.state == JobState::kQueued);
    first_ = last_;
  }
  job_ = job;
  age_seconds_ =
      job.started_unix_ms == 0 ? 0 : static_cast<double>(now_unix_ms - job.started_unix_ms) / 1000;
}

double JobPace::TasksPerSecond() const {
  const double seconds = first_ ? last_.elapsed_seconds - first_->elapsed_seconds : 0;
  return seconds > 0 ? static_cast<double>(last_.tasks_done - first_->tasks_done) / seconds : 0;
}

std::optional<double> JobPace::RemainingSeconds() const {
  const double left = job_.progress.cost_total - last_.cost_done;
  if (!first_ || IsHeld(job_) || left <= 0) {
    return std::nullopt;
  }
  const double seen = last_.cost_done - first_->cost_done;
  const double seconds = last_.elapsed_seconds - first_->elapsed_seconds;
  if (seconds > 0 && seen >= kTellingShare * (seen + left)) {
    return seconds * left / seen;
  }
  return RemainingByAge(left);
}

std::optional<double> JobPace::RemainingByAge(double cost_left) const {
  const Progress& progress = job_.progress;
  if (progress.tasks_done <= 0 || age_seconds_ <= 0 || !age_tells_) {
    return std::nullopt;
  }
  const double done_anew =
      1 - static_cast<double>(progress.tasks_reused) / static_cast<double>(progress.tasks_done);
  const double cost = progress.cost_done * done_anew;
  if (cost < kTellingShare * (cost + cost_left)) {
    return std::nullopt;
  }
  return age_seconds_ * cost_left / cost;
}

}  // namespace cohort
