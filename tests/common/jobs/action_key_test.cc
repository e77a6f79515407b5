#include "common/jobs/action_key.h"

#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(ActionKeys, DoNotDependOnWhereInTheJobTheTaskIs) {
  Task task;
  const std::string key = ActionKeys().Of(task);
  EXPECT_EQ(key.size(), 64U);
  task.number = 7;
  task.stage = "compare";
  task.cost = 3;
  EXPECT_EQ(ActionKeys().Of(task), key);
}

TEST(ActionKeys, ChangeWithEverythingThatTheResultDependsOn) {
  const Digest a = Sha256::Of("a");
  const Digest b = Sha256::Of("b");
  const TaskMesh mesh{.index = 1, .name = "a", .blob = a};
  const TaskMesh elsewhere{.index = 2, .name = "a", .blob = a};
  const TaskMesh renamed{.index = 1, .name = "b", .blob = a};
  const TaskMesh other{.index = 1, .name = "a", .blob = b};
  const std::vector<std::function<void(Task&)>> changes = {
      [](Task&) {},
      [](Task& task) { task.kind = TaskKind::kCompare; },
      [&](Task& task) { task.meshes = {mesh}; },
      [&](Task& task) { task.meshes = {elsewhere}; },
      [&](Task& task) { task.meshes = {renamed}; },
      [&](Task& task) { task.meshes = {other}; },
      [&](Task& task) { task.targets = {mesh}; },
      [&](Task& task) { task.reference = a; },
      [&](Task& task) { task.alignments = {a}; },
      [](Task& task) { task.starts = "starts"; },
      [&](Task& task) { task.partials = {a}; },
      [&](Task& task) {
        task.partials = {a, b};
      },
      [&](Task& task) {
        task.partials = {b, a};
      },
      [&](Task& task) { task.landmarks = a; },
      [](Task& task) { task.icp.tolerance *= 2; },
      [](Task& task) { task.icp.trimmed_share = 0.25; },
      [](Task& task) { task.undersampling.method = UndersamplingMethod::kRandom; },
      [](Task& task) { task.undersampling.seed = 99; },
      [](Task& task) { task.compare.retention = Retention::kSketch; },
      [](Task& task) { task.compare.sign = DistanceSign::kSigned; },
      [](Task& task) { task.position_bits = 12; },
      [](Task& task) { task.arithmetic = Arithmetic::kFidentis; },
      [](Task& task) { task.wants_placed = true; },
      [](Task& task) { task.wants_pose = true; },
      [](Task& task) { task.wants_displacement = true; },
      [](Task& task) { task.wants_variation = true; },
      [](Task& task) { task.wants_correspondences = true; },
      [](Task& task) { task.counts_reference_index = true; },
      [](Task& task) { task.moves_reference = true; },
      [](Task& task) {
        task.frame_center = {0, 0, 1e-9};
      },
  };
  std::set<std::string> keys;
  for (const auto& change : changes) {
    Task task;
    change(task);
    keys.insert(ActionKeys().Of(task));
  }
  EXPECT_EQ(keys.size(), changes.size());
}

TEST(ActionKeys, DoNotDependOnTheTaskBefore) {
  Task plain;
  Task other;
  other.icp.tolerance *= 2;
  Task third;
  third.compare.retention = Retention::kSketch;
  ActionKeys keys;
  for (const Task& task : {plain, other, third, other, other, plain, third}) {
    EXPECT_EQ(keys.Of(task), ActionKeys().Of(task));
  }
}

TEST(ActionKeys, TellWhereANameEnds) {
  Task task;
  task.meshes = {{.index = 1, .name = "a", .blob = {}}, {.index = 2, .name = "b", .blob = {}}};
  Task joined;
  joined.meshes = {{.index = 1, .name = "a0:2;1:b", .blob = {}}};
  Task moved;
  moved.meshes = {task.meshes[0]};
  moved.targets = {task.meshes[1]};
  const std::set<std::string> keys = {ActionKeys().Of(task), ActionKeys().Of(joined),
                                      ActionKeys().Of(moved)};
  EXPECT_EQ(keys.size(), 3U);
}

TEST(ActionKeys, TakeNamesThatAreNotUtf8) {
  Task task;
  task.meshes = {{.index = 0, .name = "\xff\xfe", .blob = {}}};
  EXPECT_EQ(ActionKeys().Of(task).size(), 64U);
}

}  // namespace
}  // namespace cohort
