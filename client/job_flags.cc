#include "client/job_flags.h"

#include <cmath>

#include <absl/strings/numbers.h>
#include <nlohmann/json.hpp>

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

/// "none", "random:0.1" (share), "random:2000" (count), "disk:3" (radius), "curvature:0.2".
absl::StatusOr<UndersamplingOptions> ParseUndersampling(const std::string& text) {
  const std::string expected =
      "expected none, random:SHARE, random:COUNT, disk:RADIUS, curvature:SHARE or curvature:COUNT";
  const size_t colon = text.find(':');
  const std::optional<UndersamplingMethod> method = UndersamplingFromName(text.substr(0, colon));
  UndersamplingOptions options;
  if (!method || (*method == UndersamplingMethod::kNone) != (colon == std::string::npos)) {
    return absl::InvalidArgumentError("--undersample " + text + ": " + expected);
  }
  options.method = *method;
  if (*method == UndersamplingMethod::kNone) {
    return options;
  }
  double number = 0;
  if (!absl::SimpleAtod(text.substr(colon + 1), &number) || !(number > 0)) {
    return absl::InvalidArgumentError("--undersample " + text + ": " + expected);
  }
  if (*method == UndersamplingMethod::kDisk) {
    options.radius = number;
  } else if (number <= 1) {
    options.share = number;
  } else if (number == std::floor(number) && number < 1e9) {
    options.count = static_cast<int64_t>(number);
  } else {
    return absl::InvalidArgumentError("--undersample " + text + ": " + expected);
  }
  return options;
}

}  // namespace

void JobFlags::AddTo(CLI::App& command) {
  const std::string group = "Job";
  const auto add = [&](const char* name, auto& target, const char* help) {
    return command.add_option(name, target, help)->group(group);
  };
  add("--method", method,
      "what meshes are aligned to: average (the mean shape), one (the base mesh), each (every "
      "mesh), none")
      ->capture_default_str();
  add("--preset", preset,
      "default (converge to 1e-6 mm), thesis (10 iterations a round, 0.05 mm, plain ICP) or "
      "fidentis "
      "(the numbers of FIDENTIS Analyst of 2016, defects included; takes --base, --rounds, --scale "
      "on or off, --max-iterations, --tolerance, --signed, --retention vectors or metrics)")
      ->capture_default_str();
  add("--base", base,
      "first reference: a file name, first (by name) or auto (the mesh nearest to all others) "
      "[first]");
  add("--rounds", rounds, "updates of the mean shape [3]");
  add("--mean-tolerance", mean_tolerance,
      "no further rounds once the mean shape moves by less (RMS, mm); 0: all run [0]");
  add("--metric", metric, "rms, mean, geometric-mean, min, max, variance or p75 [rms]");
  add("--symmetrize", symmetrize, "one value per pair: mean, max or directed (two values) [mean]");
  add("--neighbours", neighbours, "most similar meshes listed per mesh [3]");
  add("--position-bits", position_bits,
      "Draco quantisation of the stored meshes, 8 to 30 [18: below 1 um on a face]");
  add("--size-ratio-limit", size_ratio_limit,
      "refuse meshes this many times larger or smaller than the median, as in another unit; 0: "
      "accept all [5]");
  command
      .add_flag("--symmetric-copies", symmetric_copies,
                "replace each mesh, in this job only, by its symmetric copy (the mean of the mesh "
                "and its mirror image); meshes.csv says how asymmetric each was")
      ->group(group);
  AddAlignmentOptionsTo(command);
  AddComparisonOptionsTo(command);
}

void JobFlags::AddAlignmentOptionsTo(CLI::App& command) {
  const std::string group = "Alignment";
  const auto add = [&](const char* name, auto& target, const char* help) {
    command.add_option(name, target, help)->group(group);
  };
  add("--pose", pose,
      "coarse pose before ICP: principal-axes, landmarks or none [principal-axes; with --landmarks "
      "landmarks]");
  command
      .add_option(
          "--landmarks", landmarks,
          "landmarks for the pose, in the coordinates of the mesh files: a csv table (file, "
          "landmark, x, y, z), a .pp, .fcsv or .mrk.json per mesh (of the same name), or "
          "a folder of them; may be given several times")
      ->group(group)
      ->allow_extra_args(false);
  add("--scale", scale,
      "uniform scale: on (symmetric), least-squares (as the thesis; shrinks unlike shapes) or off "
      "[on]");
  add("--scale-limit", scale_limit,
      "largest factor between the scales before and after, >= 1; 0: none [0]");
  add("--max-iterations", max_iterations, "ICP iterations per alignment [200]");
  add("--tolerance", tolerance,
      "ICP stops when the distance changes by less, mm (RMS; without acceleration the mean); 0: "
      "never [1e-6]");
  add("--acceleration", acceleration, "of ICP: anderson or none [anderson]");
  add("--trim", trim, "share of the pairs, the farthest, that do not count in ICP, 0 to 0.9 [0]");
  add("--distance-limit", distance_limit,
      "pairs farther apart do not count in ICP, mm; 0: all count [0]");
  add("--align-boundary", align_boundary,
      "pairs on the open boundary of the reference: keep or reject in ICP [keep]");
  add("--correspondence", correspondence,
      "ICP and mean shape pair a vertex with the nearest vertex or the nearest point of the "
      "surface "
      "[vertex]");
  add("--undersample", undersample,
      "vertices that take part in ICP: none, random:SHARE, random:COUNT, disk:RADIUS (mm), "
      "curvature:SHARE, curvature:COUNT [none: all]");
}

void JobFlags::AddDistanceOptionsTo(CLI::App& command) {
  const std::string group = "Comparison";
  command
      .add_option(
          "--distance", distance,
          "from each vertex to the nearest vertex or the nearest point of the surface (does "
          "not depend on how dense the vertices are; needs faces) [vertex]")
      ->group(group);
  command
      .add_option("--boundary", boundary,
                  "distances to the open boundary of the other mesh: keep or reject [keep]")
      ->group(group);
}

void JobFlags::AddPairOptionsTo(CLI::App& command) {
  AddAlignmentOptionsTo(command);
  AddDistanceOptionsTo(command);
}

void JobFlags::AddComparisonOptionsTo(CLI::App& command) {
  const std::string group = "Comparison";
  const auto add = [&](const char* name, auto& target, const char* help) {
    command.add_option(name, target, help)->group(group);
  };
  AddDistanceOptionsTo(command);
  add("--retention", retention,
      "what is kept of the distances: vectors (all), compact (all, to 1 um), sketch (0.5 KB a "
      "pair), metrics, auto (the richest within the budget) [auto]");
  command
      .add_flag("--preview", preview,
                "before the comparison, a quick matrix: RMS over corresponding points of the mean "
                "shape; never in place of the exact one")
      ->group(group);
  command
      .add_option("--reference", reference,
                  "a finished job: its frame, options and pairs are kept, only meshes that it does "
                  "not have are aligned and compared")
      ->group("Job");
  command.add_flag("--fresh", fresh, "compute everything, also what is known from earlier jobs")
      ->group("Job");
  command
      .add_option("--priority", priority,
                  "-100 to 100: jobs of a higher one come first; equal ones share the workers")
      ->check(CLI::Range(-100, 100))
      ->capture_default_str()
      ->group("Job");
  add("--retention-budget", retention_budget_gb, "for auto, GB [2]");
  command
      .add_flag("--signed", signed_distances,
                "preset fidentis: metrics of signed distances, positive in front of the other mesh")
      ->group(group);
}

absl::Status JobFlags::SetPose(JobSpec& spec) const {
  if (!landmarks.empty()) {
    spec.pose = PoseMode::kLandmarks;
  }
  COHORT_RETURN_IF_ERROR(SetFromName(pose, "--pose", "principal-axes, landmarks or none",
                                     PoseModeFromName, spec.pose));
  if (spec.pose == PoseMode::kLandmarks && landmarks.empty()) {
    return absl::InvalidArgumentError("--pose landmarks: --landmarks FILE_OR_FOLDER is needed too");
  }
  if (spec.pose != PoseMode::kLandmarks && !landmarks.empty()) {
    return absl::InvalidArgumentError("--pose " + *pose +
                                      ": with --landmarks the pose is landmarks");
  }
  if (spec.pose == PoseMode::kLandmarks && spec.method == Method::kNone) {
    return absl::InvalidArgumentError("--landmarks: --method none moves no mesh");
  }
  return absl::OkStatus();
}

absl::Status JobFlags::SetAlignment(JobSpec& spec) const {
  COHORT_RETURN_IF_ERROR(SetPose(spec));
  COHORT_RETURN_IF_ERROR(SetFromName(
      scale, "--scale", "on, symmetric, least-squares or off",
      [&](std::string_view name) { return ScaleModeFromFlag(name, spec.icp.scale_mode); },
      spec.icp.scale_mode));
  SetIfGiven(scale_limit, spec.icp.scale_limit);
  SetIfGiven(max_iterations, spec.icp.max_iterations);
  SetIfGiven(tolerance, spec.icp.tolerance);
  COHORT_RETURN_IF_ERROR(SetFromName(acceleration, "--acceleration", "anderson or none",
                                     AccelerationFromName, spec.icp.acceleration));
  SetIfGiven(trim, spec.icp.trimmed_share);
  SetIfGiven(distance_limit, spec.icp.distance_limit);
  COHORT_RETURN_IF_ERROR(SetFromName(align_boundary, "--align-boundary", "keep or reject",
                                     BoundaryPairsFromName, spec.icp.boundary_pairs));
  COHORT_RETURN_IF_ERROR(SetFromName(correspondence, "--correspondence", "vertex or surface",
                                     CorrespondenceFromName, spec.icp.correspondence));
  if (undersample) {
    COHORT_ASSIGN_OR_RETURN(spec.undersampling, ParseUndersampling(*undersample));
  }
  return absl::OkStatus();
}

absl::Status JobFlags::SetComparison(JobSpec& spec) const {
  COHORT_RETURN_IF_ERROR(SetFromName(distance, "--distance", "vertex or surface",
                                     CorrespondenceFromName, spec.compare.correspondence));
  COHORT_RETURN_IF_ERROR(SetFromName(boundary, "--boundary", "keep or reject",
                                     BoundaryPairsFromName, spec.compare.boundary_pairs));
  COHORT_RETURN_IF_ERROR(SetFromName(retention, "--retention",
                                     "vectors, compact, sketch, metrics or auto", RetentionFromName,
                                     spec.compare.retention));
  if (signed_distances) {
    spec.compare.sign = DistanceSign::kSigned;
  }
  if (retention_budget_gb) {
    if (!(*retention_budget_gb >= 0 && *retention_budget_gb <= 1e9)) {
      return absl::InvalidArgumentError("--retention-budget: expected 0 or more GB");
    }
    spec.retention_budget = static_cast<int64_t>(*retention_budget_gb * 1e9);
  }
  return absl::OkStatus();
}

absl::Status JobFlags::KeepReference(JobSpec& spec) const {
  JobSpec expected;
  expected.metric = spec.metric;
  expected.symmetrization = spec.symmetrization;
  expected.neighbours = spec.neighbours;
  expected.priority = spec.priority;
  expected.fresh = spec.fresh;
  if (ToJson(spec) != ToJson(expected)) {
    return absl::InvalidArgumentError(
        "--reference " + reference +
        " keeps the options of that job: leave out all but --metric, --symmetrize, --neighbours, "
        "--priority and --fresh");
  }
  spec.reference_job = reference;
  return absl::OkStatus();
}

absl::StatusOr<JobSpec> JobFlags::ToSpec() const {
  const std::optional<Method> parsed_method = MethodFromName(method);
  if (!parsed_method) {
    return absl::InvalidArgumentError("--method " + method +
                                      ": expected average, one, each or none");
  }
  COHORT_ASSIGN_OR_RETURN(JobSpec spec, PresetSpec(preset, *parsed_method));
  if (base == "auto") {
    spec.base_rule = BaseRule::kAuto;
  } else if (base != "first") {
    SetIfGiven(base, spec.base);
  }
  SetIfGiven(rounds, spec.rounds);
  SetIfGiven(mean_tolerance, spec.mean_tolerance);
  COHORT_RETURN_IF_ERROR(SetAlignment(spec));
  COHORT_RETURN_IF_ERROR(SetComparison(spec));
  COHORT_RETURN_IF_ERROR(SetFromName(metric, "--metric",
                                     "rms, mean, geometric-mean, min, max, variance or p75",
                                     MetricFromName, spec.metric));
  COHORT_RETURN_IF_ERROR(SetFromName(symmetrize, "--symmetrize", "mean, max or directed",
                                     SymmetrizationFromName, spec.symmetrization));
  spec.preview = preview;
  spec.fresh = fresh;
  spec.priority = priority;
  SetIfGiven(neighbours, spec.neighbours);
  SetIfGiven(position_bits, spec.position_bits);
  SetIfGiven(size_ratio_limit, spec.size_ratio_limit);
  spec.symmetric_copies = symmetric_copies;
  if (!reference.empty()) {
    COHORT_RETURN_IF_ERROR(KeepReference(spec));
  }
  JobSpec complete = spec;
  if (UsesLandmarks()) {
    complete.landmarks = Sha256::Of("");  // Stands for those that are read once all else is right.
  }
  COHORT_RETURN_IF_ERROR(complete.Validate());
  return spec;
}

}  // namespace cohort
