#include "client/output/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace cohort {
namespace {

constexpr int kBarWidth = 30;

double ShareDone(const Progress& progress) {
  return progress.cost_total > 0 ? std::clamp(progress.cost_done / progress.cost_total, 0.0, 1.0)
                                 : 0.0;
}

}  // namespace

std::string FormatDuration(double seconds) {
  const auto total = static_cast<int64_t>(std::llround(std::max(0.0, seconds)));
  if (total >= 3600) {
    return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  }
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

std::string FormatProgress(const Job& job, const JobPace& pace, int bar_width) {
  const Progress& progress = job.progress;
  const double share = ShareDone(progress);
  const int filled = static_cast<int>(share * bar_width);
  std::string text = fmt::format(
      "{:<12} [{}{}] {:>3} %  {}/{} tasks", progress.stage.empty() ? "done" : progress.stage,
      std::string(static_cast<size_t>(filled), '#'),
      std::string(static_cast<size_t>(bar_width - filled), '.'), static_cast<int>(share * 100),
      progress.tasks_done, progress.tasks_total);
  if (pace.TasksPerSecond() > 0) {
    text += fmt::format("  {:.1f}/s", pace.TasksPerSecond());
  }
  if (job.state == JobState::kPaused) {
    text += "  paused";
  }
  if (const std::optional<double> seconds = pace.RemainingSeconds()) {
    text += "  ETA " + FormatDuration(*seconds);
  }
  return text;
}

ProgressLine::ProgressLine(std::FILE* out) : out_(out), is_terminal_(isatty(fileno(out)) == 1) {}

ProgressLine::~ProgressLine() {
  if (open_) {
    std::fputs("\n", out_);
  }
}

void ProgressLine::Say(const std::string& text) {
  std::fprintf(out_, "%s%s\n", open_ ? "\r\x1b[K" : "", text.c_str());
  std::fflush(out_);
  open_ = false;
}

void ProgressLine::Show(const Job& job, double elapsed_seconds, int64_t now_unix_ms) {
  pace_.Note(job, elapsed_seconds, now_unix_ms);
  if (job.progress.waiting_for != waiting_for_) {
    waiting_for_ = job.progress.waiting_for;
    Say(waiting_for_.empty() ? "going on" : "waiting: " + waiting_for_);
  }
  if (is_terminal_) {
    std::fprintf(out_, "\r\x1b[K%s", FormatProgress(job, pace_, kBarWidth).c_str());
    std::fflush(out_);
    open_ = true;
    return;
  }
  const int tenth = static_cast<int>(ShareDone(job.progress) * 10);
  if (job.progress.stage == stage_ && tenth == tenth_) {
    return;
  }
  stage_ = job.progress.stage;
  tenth_ = tenth;
  std::fprintf(
      out_, "%s: %s, %lld of %lld tasks done, %d %%, %s\n", job.id.value.c_str(),
      stage_.empty() ? "done" : stage_.c_str(), static_cast<long long>(job.progress.tasks_done),
      static_cast<long long>(job.progress.tasks_total),
      static_cast<int>(ShareDone(job.progress) * 100), FormatDuration(elapsed_seconds).c_str());
  std::fflush(out_);
}

}  // namespace cohort
