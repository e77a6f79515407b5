// `cohort demo`: a synthetic cohort with known truth.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iostream>
#include <memory>
#include <thread>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/output/exit_codes.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/geometry/io/write_mesh.h"
#include "common/geometry/synthetic/demo_cohort.h"

namespace cohort {
namespace {

constexpr size_t kMaxTruthMatrix = 600;

struct DemoFlags {
  std::string out;
  DemoOptions options;
  bool json = false;
};

absl::Status WriteMeshes(const DemoFlags& flags,
                         const std::vector<DemoCapture>& captures,
                         Executor& executor) {
  std::vector<absl::Status> statuses(captures.size());
  executor.ParallelFor(std::ssize(captures), [&](int64_t i) {
    const int person = static_cast<int>(i / flags.options.captures);
    const int capture = static_cast<int>(i % flags.options.captures);
    absl::Status& status = statuses[static_cast<size_t>(i)];
    const absl::StatusOr<DemoScan> scan = MakeDemoScan(flags.options, person, capture);
    status = scan.ok() ? WriteWholeFile(std::filesystem::path(flags.out) / scan->capture.file,
                                        WritePly(scan->mesh))
                       : scan.status();
  });
  for (const absl::Status& status : statuses) {
    COHORT_RETURN_IF_ERROR(status);
  }
  return absl::OkStatus();
}

absl::StatusOr<int> MakeDemo(const DemoFlags& flags) {
  COHORT_RETURN_IF_ERROR(flags.options.Validate());
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  COHORT_ASSIGN_OR_RETURN(const std::vector<DemoCapture> captures,
                          DescribeDemoCohort(flags.options));
  ThreadPool threads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  COHORT_RETURN_IF_ERROR(WriteMeshes(flags, captures, threads));
  const std::filesystem::path out = flags.out;
  COHORT_RETURN_IF_ERROR(WriteWholeFile(out / "labels.csv", LabelsCsv(captures)));
  COHORT_RETURN_IF_ERROR(WriteWholeFile(out / "truth.csv", TruthCsv(captures)));
  if (captures.size() <= kMaxTruthMatrix) {
    COHORT_ASSIGN_OR_RETURN(const Eigen::MatrixXd rms, TruthRms(captures, threads));
    COHORT_RETURN_IF_ERROR(WriteWholeFile(out / "truth_rms.csv", TruthRmsCsv(captures, rms)));
  }
  if (flags.json) {
    const nlohmann::json json = {{"folder", flags.out}, {"meshes", captures.size()}};
    std::cout << json.dump(2) << "\n";
  } else {
    std::cout << captures.size() << " synthetic scans of " << flags.options.people
              << " people are in " << flags.out << "\n  next: cohort run " << flags.out
              << " --out results --labels " << flags.out << "/labels.csv\n";
  }
  return kExitOk;
}

}  // namespace

void AddDemoCommand(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("demo", "make a synthetic cohort with known truth, to try it all");
  const auto flags = std::make_shared<DemoFlags>();
  DemoOptions& options = flags->options;
  command->add_option("--out", flags->out, "folder; made if new")->required();
  command->add_option("--people", options.people, "people")->capture_default_str();
  command->add_option("--captures", options.captures, "scans of each person; the first is neutral")
      ->capture_default_str();
  command->add_option("--vertices", options.vertices, "vertices of each mesh")
      ->capture_default_str();
  command->add_option("--seed", options.seed, "same seed, same bytes")->capture_default_str();
  command->add_option("--noise", options.noise, "scanner noise, mm")->capture_default_str();
  command
      ->add_option("--expression", options.expression_strength,
                   "strength of expressions after the first scan, 0 to 1")
      ->capture_default_str();
  command->add_flag("--json", flags->json, "print JSON for scripts");
  command->footer("Example: cohort demo --out demo --people 10 --captures 3 --vertices 10000");
  command->callback([flags, &action] { action = [flags] { return MakeDemo(*flags); }; });
}

}  // namespace cohort
