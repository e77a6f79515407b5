#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "tests/bench/alignment_task.h"
#include "tests/bench/bench.h"

namespace cohort {
namespace {

absl::Status MeasurePass(Bench& bench, benchmark::State& state, int vertices, double goal) {
  COHORT_ASSIGN_OR_RETURN(const AlignmentTask task, MakeAlignmentTask(bench, vertices));
  PacketSearch search;
  std::vector<Similarity> poses;
  std::vector<NearestSlots> nearest(task.packed.size());
  for (size_t i = 0; i < task.packed.size(); ++i) {
    COHORT_ASSIGN_OR_RETURN(const Alignment alignment, AlignOurs(*task.packed[i], *task.target,
                                                                 IcpOptions{}.scale_mode, search));
    poses.push_back(alignment.T_target_source);
    search.FindMoved(task.packed[i]->Packed(),
                     PackedTransform(poses[i], *task.packed[i], *task.target),
                     task.target->Packed(), SearchSeed::kDescent, nearest[i]);
  }
  Contest contest;
  contest.Add("nanoflann + sums", task.QueryCount(), [&] {
    return SecondsOf([&] {
      for (size_t i = 0; i < poses.size(); ++i) {
        benchmark::DoNotOptimize(task.rival->Pass(task.Source(i), RowsOf(poses[i])));
      }
    });
  });
  contest.Add("Cohort", task.QueryCount(), [&] {
    return SecondsOf([&] {
      for (size_t i = 0; i < poses.size(); ++i) {
        const PointTransform transform = PackedTransform(poses[i], *task.packed[i], *task.target);
        benchmark::DoNotOptimize(search.FindMovedAndSum(task.packed[i]->Packed(), transform,
                                                        task.target->Packed(),
                                                        SearchSeed::kPrevious, nearest[i]));
      }
    });
  });
  contest.Run(state);
  bench.figures.Add({absl::StrCat("converged ICP pass, ", vertices / 1000, "k"), AtLeast(goal),
                     contest.Ratio("nanoflann + sums", "Cohort"), " x",
                     absl::StrCat(Digits(contest.Nanoseconds("Cohort")), " ns a vertex against ",
                                  Digits(contest.Nanoseconds("nanoflann + sums")))});
  return absl::OkStatus();
}

}  // namespace

void RegisterIcpPass(Bench& bench) {
  const int rounds = bench.options.IsQuick() ? 5 : 11;
  Register(bench, "icp_pass/10k", rounds,
           [](Bench& b, benchmark::State& state) { return MeasurePass(b, state, 10'000, 13); });
  Register(bench, "icp_pass/60k", rounds,
           [](Bench& b, benchmark::State& state) { return MeasurePass(b, state, 60'000, 17); });
}

}  // namespace cohort
