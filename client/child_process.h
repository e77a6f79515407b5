#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

namespace cohort {

/// A program started by us, in a process group of its own (Ctrl-C reaches only us), its output in a
/// log file. Killed and waited for by the destructor. Not thread-safe.
class ChildProcess {
 public:
  /// @param log  appended to.
  [[nodiscard]] static absl::StatusOr<ChildProcess> Start(const std::filesystem::path& program,
                                                          const std::vector<std::string>& arguments,
                                                          const std::filesystem::path& log);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// How it ended ("exit code 1", "signal 9"); empty while it runs.
  [[nodiscard]] std::optional<std::string> Ended();
  /// Sends SIGTERM; SIGKILL if it has not ended after `seconds`.
  void Stop(double seconds);
  void AskToStop();
  [[nodiscard]] pid_t Pid() const { return pid_; }

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_ = 0;  ///< 0: ended and waited for.
  std::string end_;
};

/// The program `name` beside this one, or in the PATH.
[[nodiscard]] std::filesystem::path SiblingProgram(const std::string& name);

}  // namespace cohort
