#include "common/geometry/nearest/packed_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace cohort {
namespace {

constexpr int kLanes = PackedMesh::kLanes;
constexpr int kBoxFloats = 8;
constexpr int kLeafFloats = 3 * kLanes;
constexpr int kGroupFloats = 6 * kLanes;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The coordinate that a range is split by above, the vertex below: all keys differ, so that the
/// split does not depend on how std::nth_element works.
using Key = uint64_t;

uint32_t VertexOf(Key key) {
  return static_cast<uint32_t>(key);
}

/// Bits that compare as unsigned numbers as the floats compare (-0 is below +0).
uint32_t OrderedBits(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

int LeavesFor(size_t points) {
  return static_cast<int>((points + kLanes - 1) / kLanes);
}

/// Moves the keys below the pivot to the front; their number. Without branches on the keys, which
/// nobody could predict.
size_t Partition(std::span<Key> keys, Key pivot) {
  size_t below = 0;
  for (Key& key : keys) {
    const Key value = key;
    key = keys[below];
    keys[below] = value;
    below += static_cast<size_t>(value < pivot);
  }
  return below;
}

/// A key near rank `rank`, by a sorted sample.
template <size_t kSample>
Key PivotFor(std::span<const Key> keys, size_t rank) {
  std::array<Key, kSample> sample;
  for (size_t i = 0; i < kSample; ++i) {
    Key key = keys[(2 * i + 1) * keys.size() / (2 * kSample)];
    size_t place = i;
    for (; place > 0 && key < sample[place - 1]; --place) {
      sample[place] = sample[place - 1];
    }
    sample[place] = key;
  }
  return sample[rank * kSample / keys.size()];
}

/// std::nth_element, several times as fast where the order of the keys is random.
void MoveSmallest(std::span<Key> keys, size_t count) {
  constexpr size_t kShort = 12;
  constexpr size_t kLong = 200;
  int passes = 0;
  while (keys.size() > kShort && count > 0 && count < keys.size()) {
    if (++passes > 24) {
      break;  // The sample misled us again and again.
    }
    const Key pivot = keys.size() < kLong ? PivotFor<3>(keys, count) : PivotFor<15>(keys, count);
    const size_t below = Partition(keys, pivot);
    if (below <= count) {
      keys = keys.subspan(below);
      count -= below;
    } else {
      keys = keys.first(below);
    }
  }
  if (count < keys.size()) {
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count), keys.end());
  }
}

/// Orders at most 16 keys by vertex, by counting how many are smaller: no branches.
void SortByVertex(std::span<Key> keys) {
  std::array<uint32_t, kLanes> vertices;
  vertices.fill(0xFFFFFFFF);
  for (size_t i = 0; i < keys.size(); ++i) {
    vertices[i] = VertexOf(keys[i]);
  }
  std::array<uint32_t, kLanes> rank{};
  for (const uint32_t other : vertices) {
    for (size_t i = 0; i < kLanes; ++i) {
      rank[i] += static_cast<uint32_t>(other < vertices[i]);
    }
  }
  for (size_t i = 0; i < keys.size(); ++i) {
    keys[rank[i]] = vertices[i];
  }
}

/// Orders the keys so that each run of 16 is a leaf.
class LeafOrder {
 public:
  explicit LeafOrder(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices)
      : points_(4, vertices.cols()) {
    points_.topRows<3>() = vertices.array();
    points_.row(3).setZero();
  }

  void Sort(std::span<Key> keys) {
    while (keys.size() > kLanes) {
      const size_t left = std::bit_floor(static_cast<size_t>(LeavesFor(keys.size()) - 1)) * kLanes;
      SetCoordinate(keys, LongestSide(keys));
      MoveSmallest(keys, left);
      Sort(keys.first(left));
      keys = keys.subspan(left);
    }
    SortByVertex(keys);
  }

 private:
  [[nodiscard]] Eigen::Index LongestSide(std::span<const Key> keys) const {
    Eigen::Array4f low = points_.col(VertexOf(keys[0]));
    Eigen::Array4f high = low;
    for (const Key key : keys) {
      const auto point = points_.col(VertexOf(key));
      low = low.min(point);
      high = high.max(point);
    }
    const Eigen::Array4f extent = high - low;
    if (extent[0] >= extent[1] && extent[0] >= extent[2]) {
      return 0;
    }
    return extent[1] >= extent[2] ? 1 : 2;
  }
  void SetCoordinate(std::span<Key> keys, Eigen::Index side) const {
    for (Key& key : keys) {
      const uint32_t vertex = VertexOf(key);
      key = Key{OrderedBits(points_(side, vertex))} << 32 | vertex;
    }
  }

  Eigen::Array4Xf points_;  ///< x, y, z, 0: one load each.
};

/// Lays the boxes from `first` on into a group, empty ones after the last, and joins them.
void JoinBoxes(const std::vector<float>& boxes, size_t first, float* group, float* joined) {
  for (size_t side = 0; side < 3; ++side) {
    float least = kInfinity;
    float most = -kInfinity;
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const size_t box = (first + lane) * kBoxFloats;
      float low = kInfinity;
      float high = -kInfinity;
      if (box < boxes.size()) {
        low = boxes[box + side];
        high = boxes[box + 3 + side];
      }
      group[side * kLanes + lane] = low;
      group[(3 + side) * kLanes + lane] = high;
      least = std::min(least, low);
      most = std::max(most, high);
    }
    joined[side] = least;
    joined[3 + side] = most;
  }
}

}  // namespace

PackedMesh::PackedMesh(int vertex_count)
    : vertex_count_(vertex_count),
      leaf_count_(LeavesFor(static_cast<size_t>(vertex_count))),
      vertices_(static_cast<size_t>(leaf_count_) * kLanes),
      points_(static_cast<size_t>(leaf_count_) * kLeafFloats),
      boxes_(static_cast<size_t>(leaf_count_) * kBoxFloats) {
  assert(vertex_count >= 1 && vertex_count < (1 << 27));
}

PackedMesh::PackedMesh(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices)
    : PackedMesh(static_cast<int>(vertices.cols())) {
  std::vector<Key> keys(static_cast<size_t>(vertex_count_));
  for (size_t i = 0; i < keys.size(); ++i) {
    keys[i] = i;
  }
  LeafOrder(vertices).Sort(keys);
  for (size_t slot = 0; slot < vertices_.size(); ++slot) {
    vertices_[slot] = static_cast<int32_t>(VertexOf(keys[std::min(slot, keys.size() - 1)]));
  }
  FillLeaves([&](size_t leaf, int side, int lane) {
    return vertices(side, vertices_[leaf * kLanes + static_cast<size_t>(lane)]);
  });
}

PackedMesh PackedMesh::FromSlots(int vertex_count,
                                 std::span<const int32_t> vertex_of_slot,
                                 std::span<const float> points) {
  PackedMesh mesh(vertex_count);
  assert(vertex_of_slot.size() == mesh.vertices_.size() && points.size() == mesh.points_.size());
  std::copy(vertex_of_slot.begin(), vertex_of_slot.end(), mesh.vertices_.begin());
  mesh.FillLeaves([points](size_t leaf, int side, int lane) {
    return points[leaf * kLeafFloats + static_cast<size_t>(side * kLanes + lane)];
  });
  return mesh;
}

template <typename Coordinate>
void PackedMesh::FillLeaves(Coordinate coordinate) {
  for (size_t leaf = 0; leaf < static_cast<size_t>(leaf_count_); ++leaf) {
    float* points = &points_[leaf * kLeafFloats];
    float* box = &boxes_[leaf * kBoxFloats];
    for (int side = 0; side < 3; ++side) {
      float low = kInfinity;
      float high = -kInfinity;
      for (int lane = 0; lane < kLanes; ++lane) {
        const float value = coordinate(leaf, side, lane);
        points[side * kLanes + lane] = value;
        low = std::min(low, value);
        high = std::max(high, value);
      }
      assert(low >= -kMostCoordinate && high <= kMostCoordinate);
      box[side] = low;
      box[3 + side] = high;
    }
    box[6] = 0;
    box[7] = 0;
  }
  BuildLevels();
  view_.points = points_.data();
  view_.boxes = boxes_.data();
  view_.vertices = vertices_.data();
  view_.leaf_count = leaf_count_;
  view_.vertex_count = vertex_count_;
  diagonal_ = MeasureDiagonal();
}

void PackedMesh::BuildLevels() {
  std::vector<float> boxes(boxes_.data(), boxes_.data() + boxes_.size());
  do {
    const size_t groups = (boxes.size() / kBoxFloats + kLanes - 1) / kLanes;
    AlignedArray<float>& level = levels_.emplace_back(groups * kGroupFloats);
    std::vector<float> parents(groups * kBoxFloats);
    for (size_t group = 0; group < groups; ++group) {
      JoinBoxes(boxes, group * kLanes, &level[group * kGroupFloats], &parents[group * kBoxFloats]);
    }
    view_.levels[levels_.size() - 1] = level.data();
    view_.level_count = static_cast<int>(levels_.size());
    assert(levels_.size() <= kMostLevels);
    boxes = std::move(parents);
  } while (boxes.size() > kBoxFloats);
}

Eigen::Vector3f PackedMesh::PointOfSlot(int slot) const {
  const float* points = &points_[static_cast<size_t>(slot / kLanes) * kLeafFloats];
  const int lane = slot % kLanes;
  return {points[lane], points[kLanes + lane], points[2 * kLanes + lane]};
}

double PackedMesh::MeasureDiagonal() const {
  double squared = 0;
  for (size_t side = 0; side < 3; ++side) {
    float low = kInfinity;
    float high = -kInfinity;
    for (size_t leaf = 0; leaf < static_cast<size_t>(leaf_count_); ++leaf) {
      low = std::min(low, boxes_[leaf * kBoxFloats + side]);
      high = std::max(high, boxes_[leaf * kBoxFloats + 3 + side]);
    }
    const double extent = double{high} - double{low};
    squared += extent * extent;
  }
  return std::sqrt(squared);
}

int64_t PackedMesh::ByteCount() const {
  size_t floats = points_.size() + boxes_.size();
  for (const AlignedArray<float>& level : levels_) {
    floats += level.size();
  }
  return static_cast<int64_t>((floats + vertices_.size()) * sizeof(float) + sizeof(*this));
}

}  // namespace cohort
