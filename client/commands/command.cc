#include "client/commands/command.h"

#include <chrono>
#include <cstdio>
#include <iostream>

#include "client/output/exit_codes.h"
#include "client/output/progress_line.h"

namespace cohort {

void ServerFlags::AddTo(CLI::App& command) {
  command.add_option("--server", server, "address of cohort-server: HOST:PORT or unix:PATH")
      ->envname("COHORT_SERVER")
      ->capture_default_str();
  command.add_flag("--json", json, "print JSON for scripts");
}

absl::StatusOr<std::unique_ptr<Session>> ServerFlags::Connect() const {
  return Session::Open(server);
}

absl::StatusOr<Job> FollowJob(Session& session,
                              const JobId& id,
                              const std::function<std::string(const Job&)>& remark) {
  ProgressLine line(stderr);
  const auto start = std::chrono::steady_clock::now();
  return session.WatchJob(id, [&](const Job& job) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (const std::string text = remark ? remark(job) : ""; !text.empty()) {
      line.Say(text);
    }
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    line.Show(job, elapsed.count(),
              std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
    return true;
  });
}

int ExitCodeOfJob(const Job& job) {
  switch (job.state) {
    case JobState::kSucceeded:
      return job.rejected_meshes > 0 ? kExitRejected : kExitOk;
    case JobState::kCancelled:
      std::cerr << "cohort: job " << job.id.value << " was cancelled\n";
      return kExitCancelled;
    default:
      std::cerr << "cohort: job " << job.id.value << " failed: " << job.error << "\n";
      return kExitJobFailed;
  }
}

}  // namespace cohort
