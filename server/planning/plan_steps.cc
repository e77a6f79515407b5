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

}  // namespace

std::vector<Step> MakeSteps(const JobSpec& spec) {
  StepList steps;
  steps.Add(MakeIngestStage());
  if (spec.base_rule == BaseRule::kAuto) {
    steps.Add(MakeChooseBaseStage());
  }
  if (spec.method != Method::kNone && spec.pose == PoseMode::kPrincipalAxes) {
    steps.Add(MakePoseStage());
  }
  switch (spec.method) {
    case Method::kAverage:
      AddMeanShapeRounds(steps, spec.rounds);
      steps.Add(MakeCompareStage(), MakeVariationStage());
      steps.Add(MakeSummarizeStage(LastShape::kReference));
      break;
    case Method::kOne:
      steps.Add(MakeAlignStage("align", Displacement::kNotWanted));
      steps.Add(MakeCompareStage(), MakeVariationStage());
      steps.Add(MakeSummarizeStage(LastShape::kReferencePlusDisplacement));
      break;
    case Method::kEach:
      // The alignments to the base, which the variation needs, come out of the comparison.
      steps.Add(MakeAlignAndCompareStage());
      steps.Add(MakeVariationStage());
      steps.Add(MakeSummarizeStage(LastShape::kReferencePlusDisplacement));
      break;
    case Method::kNone:
      steps.Add(MakeCompareStage(), MakeVariationStage());
      steps.Add(MakeSummarizeStage(LastShape::kReferencePlusDisplacement));
      break;
  }
  return std::move(steps).Take();
}

}  // namespace cohort
