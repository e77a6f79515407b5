#include "client/job_flags.h"

#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// Sets `target` from a name on the command line, if one was given.
template <typename T, typename Parse>
absl::Status SetFromName(const std::optional<std::string>& name,
                         const char* option,
                         const char* expected,
                         Parse parse,
                         T& target) {
  if (!name) {
    return absl::OkStatus();
  }
  const std::optional<T> value = parse(*name);
  if (!value) {
    return absl::InvalidArgumentError(std::string(option) + " " + *name + ": expected " + expected);
  }
  target = *value;
  return absl::OkStatus();
}

/// "on" is the preset's own formula.
std::optional<ScaleMode> ScaleModeFromFlag(std::string_view name, ScaleMode preset) {
  if (name == "on") {
    return preset;
  }
  if (name == "symmetric") {
    return ScaleMode::kSymmetric;
  }
  if (name == "least-squares") {
    return ScaleMode::kFree;
  }
  return name == "off" ? std::optional(ScaleMode::kOff) : std::nullopt;
}

template <typename T>
void SetIfGiven(const std::optional<T>& value, T& target) {
  target = value.value_or(target);
}

}  // namespace

void JobFlags::AddTo(CLI::App& command) {
  const std::string group = "Job";
  command
      .add_option("--method", method,
                  "what meshes are aligned to: average (the mean shape), one (the base mesh), "
                  "each (every mesh), none")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--preset", preset,
                  "default (converge to 1e-6 mm) or thesis (10 iterations a round, 0.05 mm)")
      ->capture_default_str()
      ->group(group);
  command.add_option("--base", base, "file name of the first reference [first by name]")
      ->group(group);
  command.add_option("--rounds", rounds, "updates of the mean shape [3]")->group(group);
  command
      .add_option("--pose", pose,
                  "coarse pose before ICP: principal-axes or none "
                  "[principal-axes]")
      ->group(group);
  command
      .add_option("--scale", scale,
                  "uniform scale in the alignment: on (symmetric), least-squares (as the thesis; "
                  "shrinks unlike shapes) or off [on]")
      ->group(group);
  command.add_option("--max-iterations", max_iterations, "ICP iterations per alignment [200]")
      ->group(group);
  command
      .add_option("--tolerance", tolerance,
                  "ICP stops when the mean distance changes by less, mm; 0: never [1e-6]")
      ->group(group);
  command
      .add_option("--metric", metric, "rms, mean, geometric-mean, min, max, variance or p75 [rms]")
      ->group(group);
  command
      .add_option("--symmetrize", symmetrize,
                  "one value per pair: mean, max or directed (two values) [mean]")
      ->group(group);
  command.add_option("--neighbours", neighbours, "most similar meshes listed per mesh [3]")
      ->group(group);
  command
      .add_option("--position-bits", position_bits,
                  "Draco quantisation of the stored meshes, 8 to 30 [18: below 1 um on a face]")
      ->group(group);
  command
      .add_option("--size-ratio-limit", size_ratio_limit,
                  "refuse meshes this many times larger or smaller than the median, as in "
                  "another unit; 0: accept all [5]")
      ->group(group);
}

absl::StatusOr<JobSpec> JobFlags::ToSpec() const {
  const std::optional<Method> parsed_method = MethodFromName(method);
  if (!parsed_method) {
    return absl::InvalidArgumentError("--method " + method +
                                      ": expected average, one, each or none");
  }
  COHORT_ASSIGN_OR_RETURN(JobSpec spec, PresetSpec(preset, *parsed_method));
  SetIfGiven(base, spec.base);
  SetIfGiven(rounds, spec.rounds);
  COHORT_RETURN_IF_ERROR(
      SetFromName(pose, "--pose", "principal-axes or none", PoseModeFromName, spec.pose));
  COHORT_RETURN_IF_ERROR(SetFromName(
      scale, "--scale", "on, symmetric, least-squares or off",
      [&](std::string_view name) { return ScaleModeFromFlag(name, spec.icp.scale_mode); },
      spec.icp.scale_mode));
  SetIfGiven(max_iterations, spec.icp.max_iterations);
  SetIfGiven(tolerance, spec.icp.tolerance);
  COHORT_RETURN_IF_ERROR(SetFromName(metric, "--metric",
                                     "rms, mean, geometric-mean, min, max, variance or p75",
                                     MetricFromName, spec.metric));
  COHORT_RETURN_IF_ERROR(SetFromName(symmetrize, "--symmetrize", "mean, max or directed",
                                     SymmetrizationFromName, spec.symmetrization));
  SetIfGiven(neighbours, spec.neighbours);
  SetIfGiven(position_bits, spec.position_bits);
  SetIfGiven(size_ratio_limit, spec.size_ratio_limit);
  COHORT_RETURN_IF_ERROR(spec.Validate());
  return spec;
}

}  // namespace cohort
