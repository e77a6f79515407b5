#include "server/planning/block_partition.h"

#include <algorithm>
#include <cassert>

namespace cohort {
namespace {

/// With more of them the first blocks of a small job, and the tiles that all wait for, grow.
constexpr int64_t kMostSteps = 4;

}  // namespace

BlockPartition::BlockPartition(int64_t meshes, int64_t count)
    : meshes_(meshes),
      count_(count),
      steps_(std::min({kMostSteps, count, meshes / std::max<int64_t>(count, 1)})) {
  assert(count <= meshes && (count >= 1 || meshes == 0));
}

int64_t BlockPartition::MostMeshes() const {
  const int64_t weight = std::max<int64_t>(WeightOfLast(count_), 1);
  return (meshes_ * steps_ + weight - 1) / weight;
}

int64_t BlockPartition::Begin(int64_t block) const {
  return meshes_ - meshes_ * WeightOfLast(count_ - block) / WeightOfLast(count_);
}

int64_t BlockPartition::WeightOfLast(int64_t blocks) const {
  const int64_t growing = std::min(blocks, steps_);
  return growing * (growing + 1) / 2 + (blocks - growing) * steps_;
}

}  // namespace cohort
