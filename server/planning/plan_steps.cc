#include "server/planning/plan_steps.h"

#include <string>
#include <utility>

namespace cohort {
namespace {

/// The steps being written down.
class StepList {
 public:
  template <typename... Stages>
  void Add(Stages... stages) {
    Step step;
    (step.push_back(std::move(stages)), ...);
    steps_.push_back(std::move(step));
  }
  [[nodiscard]] std::vector<Step> Take() && { return std::move(steps_); }

 private:
  std::vector<Step> steps_;
};

void AddMeanShapeRounds(StepList& steps, int rounds) {
  for (int round = 1; round <= rounds; ++round) {
    steps.Add(MakeAlignStage("align " + std::to_string(round), Displacement::kWanted));
    steps.Add(MakeAverageStage("average " + std::to_string(round)));
  }
  steps.Add(MakeAlignStage("align " + std::to_string(rounds + 1), Displacement::kNotWanted));
}

/// What lies around the reference, then all pairs. One task makes the summary: it runs beside the
/// pairs, so that no worker waits for it, as does the quick matrix's before them.
void AddComparison(StepList& steps, const JobSpec& spec, LastShape last_shape) {
  steps.Add(MakeVariationStage(spec.preview ? Displacement::kWanted : Displacement::kNotWanted,
                               last_shape));
  if (spec.preview) {
    steps.Add(MakePreviewStage());
  }
  steps.Add(MakeSummarizeStage(last_shape), MakeCompareStage());
}

/// New meshes are brought into the frame of a reference job and compared with all; nothing else.
std::vector<Step> AddingSteps(const JobSpec& spec) {
  StepList steps;
  steps.Add(MakeIngestStage());
  if (spec.method != Method::kNone) {
    if (spec.pose != PoseMode::kNone) {
      steps.Add(MakePoseStage());
    }
    steps.Add(MakeAlignStage("align", Displacement::kNotWanted));
  }
  AddComparison(steps, spec,
                spec.method == Method::kAverage ? LastShape::kReference
                                                : LastShape::kReferencePlusDisplacement);
  return std::move(steps).Take();
}

std::vector<Step> FidentisSteps(const JobSpec& spec) {
  StepList steps;
  steps.Add(MakeIngestStage());
  if (spec.method == Method::kEach) {
    steps.Add(MakeAlignAndCompareStage());
    steps.Add(MakeFidentisSummarizeStage());
    return std::move(steps).Take();
  }
  if (spec.method == Method::kAverage) {
    for (int round = 1; round <= spec.rounds; ++round) {
      steps.Add(MakeFidentisAlignStage("align " + std::to_string(round)));
      steps.Add(MakeFidentisAverageStage("average " + std::to_string(round)));
    }
  }
  steps.Add(MakeFidentisAlignStage(
      spec.method == Method::kAverage ? "align " + std::to_string(spec.rounds + 1) : "align"));
  steps.Add(MakeCompareStage(), MakeFidentisSummarizeStage());
  return std::move(steps).Take();
}

}  // namespace

std::vector<Step> MakeSteps(const JobSpec& spec) {
  if (spec.arithmetic == Arithmetic::kFidentis) {
    return FidentisSteps(spec);
  }
  if (!spec.reference_job.empty()) {
    return AddingSteps(spec);
  }
  StepList steps;
  steps.Add(MakeIngestStage());
  if (spec.symmetric_copies) {
    steps.Add(MakeSymmetrizeStage());
  }
  if (spec.base_rule == BaseRule::kAuto) {
    steps.Add(MakeChooseBaseStage());
  }
  if (spec.method != Method::kNone && spec.pose != PoseMode::kNone) {
    steps.Add(MakePoseStage());
  }
  switch (spec.method) {
    case Method::kAverage:
      AddMeanShapeRounds(steps, spec.rounds);
      AddComparison(steps, spec, LastShape::kReference);
      break;
    case Method::kOne:
      steps.Add(MakeAlignStage("align", Displacement::kNotWanted));
      AddComparison(steps, spec, LastShape::kReferencePlusDisplacement);
      break;
    case Method::kEach:
      // The alignments to the base, which the variation needs, come out of the comparison.
      steps.Add(MakeAlignAndCompareStage());
      steps.Add(
          MakeVariationStage(Displacement::kNotWanted, LastShape::kReferencePlusDisplacement));
      steps.Add(MakeSummarizeStage(LastShape::kReferencePlusDisplacement));
      break;
    case Method::kNone:
      AddComparison(steps, spec, LastShape::kReferencePlusDisplacement);
      break;
  }
  return std::move(steps).Take();
}

}  // namespace cohort
