// `cohort gc`: has a server remove the blobs that nothing needs.
#include <iostream>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/output/exit_codes.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

struct GcFlags {
  ServerFlags server;
  std::optional<double> age_hours;
  std::optional<double> remember_days;
};

absl::StatusOr<int> Collect(const GcFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const v1::CollectGarbageResponse count,
                          session->CollectGarbage(flags.age_hours, flags.remember_days));
  if (flags.server.json) {
    std::cout << nlohmann::json({{"removed_blobs", count.blobs()},
                                 {"removed_bytes", count.bytes()},
                                 {"kept_blobs", count.kept_blobs()},
                                 {"kept_bytes", count.kept_bytes()}})
                     .dump(2)
              << "\n";
  } else {
    std::cout << fmt::format("removed {} blobs, {:.1f} MB; {} blobs stay, {:.1f} MB\n",
                             count.blobs(), static_cast<double>(count.bytes()) / 1e6,
                             count.kept_blobs(), static_cast<double>(count.kept_bytes()) / 1e6);
  }
  return kExitOk;
}

}  // namespace

void AddGcCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "gc", "remove from a server what nothing needs, as it does by itself once a day");
  const auto flags = std::make_shared<GcFlags>();
  flags->server.AddTo(*command);
  command
      ->add_option("--age-hours", flags->age_hours,
                   "only what is at least that old (default: the server's --gc-age-hours); what "
                   "a running task has just written may have to be done again if it is short")
      ->check(CLI::Range(0.0, 8760.0));
  command
      ->add_option("--remember-days", flags->remember_days,
                   "forget results of tasks that no job has any more after so long (default: "
                   "the server's --gc-remember-days)")
      ->check(CLI::Range(0.0, 36500.0));
  command->footer(
      "After cohort delete and cohort remove:\n"
      "Example: cohort gc --remember-days 0");
  command->callback([flags, &action] { action = [flags] { return Collect(*flags); }; });
}

}  // namespace cohort
