#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/nearest/packet_search.h"
#include "tests/bench/bench.h"
#include "tests/bench/search_duel.h"

namespace cohort {
namespace {

constexpr int kMeshes = 60;
constexpr int kVertices = 20'000;
constexpr int kThreads = 2;
constexpr double kLeastShare = 0.8;
constexpr double kLeastGain = 1.85;
constexpr int kServiceRounds = 7;
constexpr int kWorkersRounds = 9;

/// What one job through the service took.
struct ServiceRun {
  double pairs = 0;
  double compare_seconds = 0;  // wall time of the compare stage
  double job_seconds = 0;      // from its submission to its last result
};

/// Where runs write. Each has a folder of its own, and all are removed at the end: the file system
/// looks for free inodes long after many have been freed, which a user's run does not meet.
class RunFolders {
 public:
  explicit RunFolders(const Bench& bench)
      : root_(absl::StrCat(bench.options.data_folder, "/service")) {
    std::filesystem::remove_all(root_);
  }
  ~RunFolders() {
    std::error_code ignored;  // The next run removes them.
    std::filesystem::remove_all(root_, ignored);
  }
  RunFolders(const RunFolders&) = delete;
  RunFolders& operator=(const RunFolders&) = delete;

  [[nodiscard]] std::string Next() { return absl::StrCat(root_, "/", next_++); }

 private:
  std::string root_;
  int next_ = 0;
};

/// Starts `cohort run` with so many workers and reads its job.json.
/// @return kInternal if the program fails, kUnavailable if it does not say what the stage took.
absl::StatusOr<ServiceRun> RunService(const Bench& bench,
                                      RunFolders& folders,
                                      int workers,
                                      int threads) {
  const std::string out = folders.Next();
  const std::string command =
      absl::StrCat("'", bench.options.cohort_program, "' run '",
                   bench.faces.PreparedFolder(kVertices), "' --out '", out, "' --workers ", workers,
                   " --threads ", threads, " --retention sketch --no-report --keep-data >'",
                   bench.options.data_folder, "/service.log' 2>&1");
  if (std::system(command.c_str()) != 0) {
    return absl::InternalError(absl::StrCat("`cohort run --retention sketch` failed, see ",
                                            bench.options.data_folder, "/service.log"));
  }
  std::ifstream file(out + "/job.json");
  const nlohmann::json job = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  const nlohmann::json::json_pointer seconds("/run/stages/compare/seconds");
  const nlohmann::json::json_pointer whole("/run/seconds");
  const nlohmann::json::json_pointer pairs("/counters/pairs");
  if (job.is_discarded() || !job.contains(seconds) || !job.contains(pairs) ||
      !job.contains(whole)) {
    return absl::UnavailableError("job.json does not say what the compare stage took");
  }
  return ServiceRun{job[pairs].get<double>(), job[seconds].get<double>(), job[whole].get<double>()};
}

/// Wall seconds of the same pairs by the bare kernel: search, metrics and sketch.
double RunKernel(std::span<const BenchMesh> meshes, int thread_count) {
  const auto start = std::chrono::steady_clock::now();
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    PacketSearch search;
    NearestSlots nearest;
    DistanceScratch scratch;
    const size_t pairs = meshes.size() * meshes.size();
    for (size_t pair = next++; pair < pairs; pair = next++) {
      const BenchMesh& source = meshes[pair / meshes.size()];
      search.Find(source.packed, meshes[pair % meshes.size()].packed, nearest);
      benchmark::DoNotOptimize(MeasureSquaredDistances(
          {nearest.squared_distances.data(), static_cast<size_t>(source.packed.VertexCount())},
          scratch));
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(static_cast<size_t>(thread_count));
  for (int i = 0; i < thread_count; ++i) {
    threads.emplace_back(work);
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

absl::Status MeasureService(Bench& bench, RunFolders& folders, benchmark::State& state) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(kVertices, kMeshes));
  Figure figure{
      "pairs a second through the service, of the kernel's", AtLeast(kLeastShare), {}, "", ""};
  // As `cohort run` does it by itself on two processors: one worker with two slots.
  const absl::StatusOr<ServiceRun> first = RunService(bench, folders, 1, kThreads);
  if (absl::IsUnavailable(first.status())) {
    figure.note = std::string(first.status().message());
    bench.figures.Add(figure);
    return absl::OkStatus();
  }
  COHORT_RETURN_IF_ERROR(first.status());
  absl::Status failure;
  Contest contest;
  contest.Add("service", first->pairs, [&] {
    const absl::StatusOr<ServiceRun> run = RunService(bench, folders, 1, kThreads);
    failure.Update(run.status());
    return run.ok() ? run->compare_seconds : 1;
  });
  contest.Add("kernel", static_cast<double>(kMeshes * kMeshes),
              [&] { return RunKernel(faces, kThreads); });
  contest.Run(state);
  COHORT_RETURN_IF_ERROR(failure);
  figure.value = contest.Ratio("kernel", "service");
  figure.note = absl::StrCat(kMeshes, " meshes of ", kVertices, ", wall time on ", kThreads,
                             " threads: ", Digits(contest.Nanoseconds("service") * 1e-6),
                             " ms a pair against ", Digits(contest.Nanoseconds("kernel") * 1e-6));
  bench.figures.Add(figure);
  return absl::OkStatus();
}

/// The whole job, from one worker with one slot to two of them. Beside it what the machine itself
/// gains from a second thread of the bare kernel.
absl::Status MeasureWorkers(Bench& bench, RunFolders& folders, benchmark::State& state) {
  COHORT_ASSIGN_OR_RETURN(const auto faces, bench.faces.Get(kVertices, kMeshes));
  absl::Status failure;
  Contest contest;
  for (const int workers : {1, 2}) {
    contest.Add(absl::StrCat(workers), 1, [&, workers] {
      const absl::StatusOr<ServiceRun> run = RunService(bench, folders, workers, 1);
      failure.Update(run.status());
      return run.ok() ? run->job_seconds : 1;
    });
  }
  for (const int threads : {1, 2}) {
    contest.Add(absl::StrCat("kernel ", threads), 1,
                [&, threads] { return RunKernel(faces, threads); });
  }
  contest.Run(state);
  COHORT_RETURN_IF_ERROR(failure);
  bench.figures.Add({"two workers against one, the whole job", AtLeast(kLeastGain),
                     contest.Ratio("1", "2"), " x",
                     absl::StrCat(kMeshes, " meshes of ", kVertices,
                                  ", wall time: ", Digits(contest.Nanoseconds("1") * 1e-9),
                                  " s and ", Digits(contest.Nanoseconds("2") * 1e-9),
                                  " s; two threads of the bare kernel against one ",
                                  Digits(contest.Ratio("kernel 1", "kernel 2")), " x")});
  return absl::OkStatus();
}

}  // namespace

void RegisterService(Bench& bench) {
  if (!bench.options.IsQuick() && !bench.options.cohort_program.empty()) {
    const auto folders = std::make_shared<RunFolders>(bench);
    Register(bench, "service/20k", kServiceRounds, [folders](Bench& b, benchmark::State& state) {
      return MeasureService(b, *folders, state);
    });
    Register(bench, "workers/20k", kWorkersRounds, [folders](Bench& b, benchmark::State& state) {
      return MeasureWorkers(b, *folders, state);
    });
  }
}

}  // namespace cohort
