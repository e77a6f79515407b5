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

void AddMeanShapeRounds(StepList& steps, const JobSpec& spec, const VariationParts& variation) {
  const bool finds_pose = spec.pose != PoseMode::kNone;
  for (int round = 1; round <= spec.rounds; ++round) {
    steps.Add(MakeAlignStage("align " + std::to_string(round),
                             {.pose = finds_pose && round == 1, .displacement = true}));
    steps.Add(MakeAverageStage("average " + std::to_string(round)));
  }
  steps.Add(MakeAlignStage("align " + std::to_string(spec.rounds + 1),
                           {.pose = finds_pose && spec.rounds == 0, .variation = variation}));
}

/// All pairs. One task makes the summary of the variation: it runs beside the pairs, so that no
/// worker waits for it, as does the quick matrix's before them.
void AddComparison(StepList& steps, const JobSpec& spec, LastShape last_shape) {
  if (spec.preview) {
    steps.Add(MakePreviewStage());
  }
  steps.Add(MakeSummarizeStage(last_shape), MakeCompareStage());
}

/// New meshes are brought into the frame of a reference job and compared with all; nothing else.
std::vector<Step> AddingSteps(const JobSpec& spec) {
  const LastShape last_shape = spec.method == Method::kAverage
                                   ? LastShape::kReference
                                   : LastShape::kReferencePlusDisplacement;
  StepList steps;
  steps.Add(MakeIngestStage());
  if (spec.method != Method::kNone) {
    steps.Add(MakeAlignStage("align", {.pose = spec.pose != PoseMode::kNone}));
  }
  // Of all meshes, also those that were aligned before.
  steps.Add(MakeVariationStage({.last_shape = last_shape, .correspondences = spec.preview}));
  AddComparison(steps, spec, last_shape);
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
  const bool finds_pose = spec.pose != PoseMode::kNone;
  switch (spec.method) {
    case Method::kAverage:
      AddMeanShapeRounds(steps, spec,
                         {.last_shape = LastShape::kReference, .correspondences = spec.preview});
      AddComparison(steps, spec, LastShape::kReference);
      break;
    case Method::kOne:
      steps.Add(MakeAlignStage(
          "align", {.pose = finds_pose,
                    .variation = VariationParts{.last_shape = LastShape::kReferencePlusDisplacement,
                                                .correspondences = spec.preview}}));
      AddComparison(steps, spec, LastShape::kReferencePlusDisplacement);
      break;
    case Method::kEach:
      if (finds_pose) {
        steps.Add(MakePoseStage());
      }
      // The alignments to the base, which the variation needs, come out of the comparison.
      steps.Add(MakeAlignAndCompareStage());
      steps.Add(MakeVariationStage({.last_shape = LastShape::kReferencePlusDisplacement}));
      steps.Add(MakeSummarizeStage(LastShape::kReferencePlusDisplacement));
      break;
    case Method::kNone:
      steps.Add(MakeVariationStage(
          {.last_shape = LastShape::kReferencePlusDisplacement, .correspondences = spec.preview}));
      AddComparison(steps, spec, LastShape::kReferencePlusDisplacement);
      break;
  }
  return std::move(steps).Take();
}

}  // namespace cohort
