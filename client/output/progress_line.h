#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "client/output/job_pace.h"
#include "common/jobs/job_state.h"

namespace cohort {

/// Shows a job's progress while it runs: on a terminal one line that is drawn over (bar, tasks,
/// rate, ETA), elsewhere a plain line per stage and per tenth. Not thread-safe.
class ProgressLine {
 public:
  /// @param out  usually stderr.
  explicit ProgressLine(std::FILE* out);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// @param elapsed_seconds, now_unix_ms  as JobPace::Note.
  void Show(const Job& job, double elapsed_seconds, int64_t now_unix_ms);
  /// Puts a line of text above it.
  void Say(const std::string& text);

 private:
  std::FILE* out_;
  const bool is_terminal_;
  bool open_ = false;  ///< The terminal's line has text.
  JobPace pace_;
  std::string stage_;
  std::string waiting_for_;
  int tenth_ = -1;
};

/// "1:02:03", "4:05" or "0:07".
[[nodiscard]] std::string FormatDuration(double seconds);

/// The text of one progress line, e.g.
/// "align 2      [########............]  41 %   210/512 tasks  12.3/s  ETA 0:25".
[[nodiscard]] std::string FormatProgress(const Job& job, const JobPace& pace, int bar_width);

}  // namespace cohort
