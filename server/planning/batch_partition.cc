#include "server/planning/batch_partition.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace cohort {
namespace {

constexpr int64_t kShares = 4;  ///< A batch is at most this part of what is left.

constexpr double kAlignSecondsPerVertex = 4e-7;  ///< One alignment, roughly.
constexpr double kLeastBatchSeconds = 0.05;  ///< Else handing a batch out would cost some per cent,
constexpr double kLeastLastSeconds = 0.01;   ///< and of one of the last ones a tenth of it,
constexpr int64_t kLeastBatches = 10;        ///< unless there were fewer batches than these.
constexpr int64_t kManyBatches = 64;         ///< No more are needed,
constexpr int64_t kMaxBatchSize = 16;        ///< unless they would grow beyond this.

int64_t DividedUp(int64_t number, int64_t by) {
  return (number + by - 1) / by;
}

}  // namespace

BatchPartition::BatchPartition(int64_t meshes, int64_t size, int64_t least)
    : meshes_(meshes), size_(size), least_(least) {
  assert(meshes >= 0 && least >= 1 && least <= size);
  // As long as more than this is left, a share of it is a full batch.
  const int64_t end_game = kShares * (size_ - 1);
  full_ = meshes_ > end_game ? DividedUp(meshes_ - end_game, size_) : 0;
  full_ = std::min(full_, meshes_ / size_);
  count_ = full_;
  for (int64_t begin = full_ * size_; begin < meshes_; begin = Next(begin).end) {
    ++count_;
  }
}

MeshRange BatchPartition::Next(int64_t begin) const {
  const int64_t left = meshes_ - begin;
  const int64_t size = std::clamp(DividedUp(left, kShares), least_, size_);
  return {.begin = begin, .end = begin + std::min(size, left)};
}

MeshRange BatchPartition::At(int64_t batch) const {
  assert(batch >= 0 && batch < count_);
  if (batch < full_) {
    return {.begin = batch * size_, .end = (batch + 1) * size_};
  }
  MeshRange range = Next(full_ * size_);
  for (int64_t before = full_; before < batch; ++before) {
    range = Next(range.end);
  }
  return range;
}

BatchPartition BatchesOf(int64_t meshes, double mean_vertices) {
  const double mesh_seconds = std::max(1.0, mean_vertices) * kAlignSecondsPerVertex;
  const auto for_seconds = [&](double seconds) {
    return std::min(seconds / mesh_seconds, static_cast<double>(kMaxBatchSize));
  };
  const auto worthwhile = std::min(static_cast<int64_t>(std::ceil(for_seconds(kLeastBatchSeconds))),
                                   meshes / kLeastBatches);
  const int64_t size =
      std::clamp<int64_t>(std::max(meshes / kManyBatches, worthwhile), 1, kMaxBatchSize);
  // Rounded, so that a guess of the vertices gives the same batches as their number mostly.
  const auto last = std::bit_floor(static_cast<uint64_t>(for_seconds(kLeastLastSeconds)));
  return {meshes, size, std::clamp<int64_t>(static_cast<int64_t>(last), 1, size)};
}

}  // namespace cohort
