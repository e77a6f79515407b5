#include <string>
#include <string_view>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "tests/bench/alignment_task.h"
#include "tests/bench/bench.h"

namespace cohort {
namespace {

constexpr double kMostIterations = 35;

/// What the alignments of one task came to, in the order of its sources.
struct Outcome {
  std::vector<double> iterations;
  double rms = 0;  // mean over the sources, mm

  void Add(int passes, double rms_residual, const AlignmentTask& task) {
    iterations.push_back(passes);
    rms += rms_residual / static_cast<double>(task.sources.size());
  }
};

absl::StatusOr<Outcome> RunOurs(const AlignmentTask& task, ScaleMode mode) {
  Outcome outcome;
  PacketSearch search;
  for (const auto& source : task.packed) {
    COHORT_ASSIGN_OR_RETURN(const Alignment alignment,
                            AlignOurs(*source, *task.target, mode, search));
    if (!alignment.converged) {
      return absl::FailedPreconditionError("a face did not converge");
    }
    outcome.Add(alignment.iterations, alignment.rms_residual, task);
  }
  return outcome;
}

Outcome RunPlain(const AlignmentTask& task, ScaleMode mode) {
  Outcome outcome;
  for (size_t i = 0; i < task.sources.size(); ++i) {
    const PlainIcpResult result = AlignPlainly(task, i, mode);
    outcome.Add(result.iterations, result.rms, task);
  }
  return outcome;
}

void AddFigures(Bench& bench,
                const Contest& contest,
                const std::string& label,
                Goal goal,
                const Outcome& ours,
                const Outcome& plain) {
  const auto ms = [&](std::string_view name) { return Digits(contest.Nanoseconds(name) * 1e-6); };
  bench.figures.Add(
      {absl::StrCat("whole alignment to 1e-6 mm, ", label), goal,
       contest.Ratio("plain ICP", "Cohort"), " x",
       absl::StrCat(ms("Cohort"), " ms against ", ms("plain ICP"), "; RMS ", Digits(ours.rms),
                    " mm against ", Digits(plain.rms), "; with the ", "source's index ",
                    Digits(contest.Ratio("plain ICP", "+ index")), " x")});
  bench.figures.Add({absl::StrCat("iterations of an alignment, ", label), AtMost(kMostIterations),
                     Median(ours.iterations), "",
                     absl::StrCat("median of ", ours.iterations.size(), "; plain ICP ",
                                  Digits(Median(plain.iterations)))});
}

absl::Status MeasureAlignment(
    Bench& bench, benchmark::State& state, int vertices, ScaleMode mode, Goal goal) {
  COHORT_ASSIGN_OR_RETURN(const AlignmentTask task, MakeAlignmentTask(bench, vertices));
  COHORT_ASSIGN_OR_RETURN(const Outcome ours, RunOurs(task, mode));
  const auto count = static_cast<double>(task.sources.size());
  PacketSearch search;
  Outcome plain;
  Contest contest;
  contest.Add("Cohort", count, [&] {
    return SecondsOf([&] {
      for (const auto& source : task.packed) {
        benchmark::DoNotOptimize(AlignOurs(*source, *task.target, mode, search));
      }
    });
  });
  contest.Add("+ index", count, [&] {
    return SecondsOf([&] {
      for (const Eigen::Matrix3Xd& source : task.sources) {
        benchmark::DoNotOptimize(AlignOurs(IcpMesh(source), *task.target, mode, search));
      }
    });
  });
  contest.Add(
      "plain ICP", count, [&] { return SecondsOf([&] { plain = RunPlain(task, mode); }); },
      bench.options.IsQuick() ? 1 : 3);
  contest.Run(state);
  const std::string label = absl::StrCat(vertices / 1000, "k, scale ",
                                         mode == ScaleMode::kFree ? "least-squares" : "symmetric");
  AddFigures(bench, contest, label, goal, ours, plain);
  return absl::OkStatus();
}

void RegisterSize(Bench& bench, int vertices, Goal goal) {
  for (const ScaleMode mode : {ScaleMode::kSymmetric, ScaleMode::kFree}) {
    if (mode == ScaleMode::kFree && bench.options.IsQuick()) {
      continue;
    }
    Register(bench,
             absl::StrCat("alignment/", vertices / 1000, "k/",
                          mode == ScaleMode::kFree ? "free" : "symmetric"),
             3, [=](Bench& b, benchmark::State& state) {
               return MeasureAlignment(b, state, vertices, mode, goal);
             });
  }
}

}  // namespace

void RegisterAlignment(Bench& bench) {
  RegisterSize(bench, 10'000, AtLeast(35));
  RegisterSize(bench, 60'000, AtLeast(50));
}

}  // namespace cohort
