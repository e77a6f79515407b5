#include "client/commands/analysis_flags.h"

namespace cohort {

void MatrixFlags::AddTo(CLI::App& command) {
  command.add_option("--metric", metric,
                     "of a job on the server: another metric than the job's (rms, mean, "
                     "geometric-mean, min, max, variance, p75)");
  command.add_option("--symmetrize", symmetrize,
                     "mean or max: what stands for the two values of a pair of a directed matrix");
}

absl::StatusOr<AnalysisSource> MatrixFlags::ToSource(const std::string& source,
                                                     const std::string& server) const {
  AnalysisSource from{.source = source, .server = server, .metric = {}, .symmetrize = {}};
  if (!metric.empty()) {
    from.metric = MetricFromName(metric);
    if (!from.metric) {
      return absl::InvalidArgumentError(
          "--metric " + metric + ": expected rms, mean, geometric-mean, min, max, variance or p75");
    }
  }
  if (!symmetrize.empty()) {
    if (symmetrize != "mean" && symmetrize != "max") {
      return absl::InvalidArgumentError("--symmetrize " + symmetrize + ": expected mean or max");
    }
    from.symmetrize = symmetrize == "mean" ? PairRule::kMean : PairRule::kMax;
  }
  return from;
}

std::string AsText(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace cohort
