#include "common/geometry/nearest/packed_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace cohort {
namespace {

constexpr size_t kLanes = PackedSurface::kLanes;
constexpr size_t kBoxFloats = 8;
constexpr size_t kGroupFloats = 6 * kLanes;
constexpr size_t kFrameFloats = PackedSurface::kFrameRows * kLanes;
constexpr size_t kTurnedFloats = PackedSurface::kTurnedFloats;
constexpr size_t kCornerFloats = PackedSurface::kCornerFloats;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Edges and heights that are shorter count as none to the search, whose margin covers them: the
/// reciprocal of the square leaves float32.
constexpr double kShortest = 1e-18;

using Corners = std::array<Eigen::Vector3f, 3>;

bool Precedes(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  if (a.x() != b.x()) {
    return a.x() < b.x();
  }
  return a.y() != b.y() ? a.y() < b.y() : a.z() < b.z();
}

/// Ascending: an edge shared by two triangles is then measured the same way in both.
Corners Sorted(Corners corners) {
  if (Precedes(corners[1], corners[0])) {
    std::swap(corners[0], corners[1]);
  }
  if (Precedes(corners[2], corners[1])) {
    std::swap(corners[1], corners[2]);
    if (Precedes(corners[1], corners[0])) {
      std::swap(corners[0], corners[1]);
    }
  }
  return corners;
}

Eigen::Vector3d AnyPerpendicular(const Eigen::Vector3d& axis) {
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d unit = Eigen::Vector3d::Unit(least);
  return (unit - unit.dot(axis) * axis).normalized();
}

/// See PackedSurface::View::frames.
struct Frame {
  Eigen::Vector3f origin;
  Eigen::Matrix3d axes;  ///< Columns X, Y, Z.
  double length;
  double x;
  double y;

  explicit Frame(const Corners& corners) {
    const Eigen::Vector3d a = corners[0].cast<double>();
    const Eigen::Vector3d b = corners[1].cast<double>();
    const Eigen::Vector3d c = corners[2].cast<double>();
    const double ab = (b - a).squaredNorm();
    const double bc = (c - b).squaredNorm();
    const double ca = (a - c).squaredNorm();
    if (ab >= bc && ab >= ca) {
      Set(corners[0], b - a, c - a, ab);
    } else if (bc >= ca) {
      Set(corners[1], c - b, a - b, bc);
    } else {
      Set(corners[2], a - c, b - c, ca);
    }
  }
  void Set(const Eigen::Vector3f& from,
           const Eigen::Vector3d& longest,
           const Eigen::Vector3d& third,
           double squared_length) {
    origin = from;
    length = std::sqrt(squared_length);
    if (length <= kShortest) {
      axes.setIdentity();
      length = x = y = 0;
      return;
    }
    axes.col(0) = longest / length;
    x = axes.col(0).dot(third);
    Eigen::Vector3d height = third - x * axes.col(0);
    height -= height.dot(axes.col(0)) * axes.col(0);  // Again: the first is not exact in needles.
    y = height.norm();
    if (y <= std::max(kShortest, 1e-15 * length)) {
      y = 0;
      axes.col(1) = AnyPerpendicular(axes.col(0));
    } else {
      axes.col(1) = height / y;
    }
    axes.col(2) = axes.col(0).cross(axes.col(1));
  }
  /// Writes column `lane` of the rows.
  void Write(float* rows) const {
    const auto write = [&rows](double value) {
      *rows = static_cast<float>(value);
      rows += kLanes;
    };
    for (const float value : origin) {
      write(double{value});
    }
    for (const double value : axes.reshaped()) {
      write(value);
    }
    write(length);
    write(x);
    write(y);
    for (const double side : {length - x, x}) {
      const double square = side * side + y * y;
      write(square > kShortest * kShortest ? 1 / square : 0);
    }
  }
};

/// Writes centre, axes and half sides of a box around the corners, its third axis along `normal`.
void WriteTurnedBox(const std::array<Corners, kLanes>& triangles,
                    const Eigen::Vector3d& normal,
                    const Eigen::Vector3d& middle,
                    float* to) {
  Eigen::Matrix3d turned;  // Rows are the axes.
  const double length = normal.norm();
  turned.row(2) = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitZ();
  turned.row(0) = AnyPerpendicular(turned.row(2).transpose());
  turned.row(1) = turned.row(2).cross(turned.row(0));
  const Eigen::Matrix3d axes = turned.cast<float>().cast<double>();  // As the kernels have them.
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  for (const Corners& corners : triangles) {
    for (const Eigen::Vector3f& corner : corners) {
      const Eigen::Array3d at = axes * (corner.cast<double>() - middle);
      low = low.min(at);
      high = high.max(at);
    }
  }
  const Eigen::Vector3f centre =
      (middle + axes.transpose() * (0.5 * (low + high)).matrix()).cast<float>();
  // Where the box lies about the centre as rounded.
  const Eigen::Array3d shift = axes * (centre.cast<double>() - middle);
  const Eigen::Array3d half = (high - shift).max(shift - low);
  for (int i = 0; i < 3; ++i) {
    to[i] = centre[i];
    for (int side = 0; side < 3; ++side) {
      to[3 + 3 * i + side] = static_cast<float>(axes(i, side));
    }
    to[12 + i] = static_cast<float>(half[i]);
  }
  to[15] = 0;
}

/// Low x, y, z, high x, y, z, two unused.
using Box = std::array<float, kBoxFloats>;
/// Farther than any: a missing child.
constexpr Box kNoBox = {kInfinity, kInfinity, kInfinity, -kInfinity, -kInfinity, -kInfinity, 0, 0};

/// Writes 16 boxes in rows; the box around them.
Box FillGroup(const float* boxes, float* rows) {
  Box around = kNoBox;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    for (size_t side = 0; side < 3; ++side) {
      const float low = boxes[lane * kBoxFloats + side];
      const float high = boxes[lane * kBoxFloats + 3 + side];
      rows[side * kLanes + lane] = low;
      rows[(3 + side) * kLanes + lane] = high;
      around[side] = std::min(around[side], low);
      around[3 + side] = std::max(around[3 + side], high);
    }
  }
  return around;
}

std::vector<int32_t> OrderFaces(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                                const Eigen::Ref<const Matrix3Xi>& faces) {
  Eigen::Matrix3Xf centroids(3, faces.cols());
  for (Eigen::Index face = 0; face < faces.cols(); ++face) {
    assert(faces.col(face).minCoeff() >= 0 && faces.col(face).maxCoeff() < vertices.cols());
    centroids.col(face) = (vertices.col(faces(0, face)) + vertices.col(faces(1, face)) +
                           vertices.col(faces(2, face))) /
                          3.0F;
  }
  const PackedMesh order(centroids);
  return {order.VertexOfSlot().begin(), order.VertexOfSlot().end()};
}

}  // namespace

PackedSurface::PackedSurface(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                             const Eigen::Ref<const Matrix3Xi>& faces)
    : face_count_(static_cast<int>(faces.cols())),
      leaf_count_(static_cast<int>((faces.cols() + PackedMesh::kLanes - 1) / PackedMesh::kLanes)) {
  assert(faces.cols() >= 1 && faces.cols() < (int64_t{1} << 27));
  faces_ = OrderFaces(vertices, faces);
  const auto leaves = static_cast<size_t>(leaf_count_);
  frames_.Reset(leaves * kFrameFloats);
  turned_boxes_.Reset(leaves * kTurnedFloats);
  corners_.Reset(faces_.size() * kCornerFloats);
  std::vector<float> boxes(leaves * kBoxFloats);
  for (int leaf = 0; leaf < leaf_count_; ++leaf) {
    FillLeaf(leaf, vertices, faces, &boxes[static_cast<size_t>(leaf) * kBoxFloats]);
  }
  view_.boxes.leaf_count = leaf_count_;
  BuildLevels(std::move(boxes));
  view_.frames = frames_.data();
  view_.turned_boxes = turned_boxes_.data();
  view_.corners = corners_.data();
}

void PackedSurface::FillLeaf(int leaf,
                             const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                             const Eigen::Ref<const Matrix3Xi>& faces,
                             float* box) {
  std::array<Corners, kLanes> triangles;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Array3f low = Eigen::Array3f::Constant(kInfinity);
  Eigen::Array3f high = -low;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const size_t slot = static_cast<size_t>(leaf) * kLanes + lane;
    const int32_t face = faces_[slot];
    Corners& corners = triangles[lane];
    for (size_t i = 0; i < 3; ++i) {
      corners[i] = vertices.col(faces(static_cast<Eigen::Index>(i), face));
      low = low.min(corners[i].array());
      high = high.max(corners[i].array());
    }
    const Frame frame(corners);
    frame.Write(&frames_[static_cast<size_t>(leaf) * kFrameFloats + lane]);
    const Eigen::Vector3d area = frame.axes.col(2) * (frame.length * frame.y);
    normal += normal.dot(area) < 0 ? Eigen::Vector3d(-area) : area;
    corners = Sorted(corners);
    float* to = &corners_[slot * kCornerFloats];
    for (const Eigen::Vector3f& corner : corners) {
      to = std::copy_n(corner.data(), 3, to);
    }
    *to++ = std::bit_cast<float>(face);
    std::fill_n(to, 2, 0.0F);
  }
  assert(low.minCoeff() >= -PackedMesh::kMostCoordinate &&
         high.maxCoeff() <= PackedMesh::kMostCoordinate);
  const Eigen::Vector3d extent = (high.cast<double>() - low.cast<double>()).matrix();
  WriteTurnedBox(triangles, normal, low.cast<double>().matrix() + 0.5 * extent,
                 &turned_boxes_[static_cast<size_t>(leaf) * kTurnedFloats]);
  view_.reach = std::max(view_.reach, static_cast<float>(1.0001 * extent.norm()));
  std::copy_n(low.data(), 3, box);
  std::copy_n(high.data(), 3, box + 3);
}

void PackedSurface::BuildLevels(std::vector<float> boxes) {
  size_t groups = 0;
  while (groups != 1) {
    const size_t children = boxes.size() / kBoxFloats;
    groups = (children + kLanes - 1) / kLanes;
    AlignedArray<float>& level = levels_.emplace_back(groups * kGroupFloats);
    std::vector<float> parents;
    parents.reserve(groups * kBoxFloats);
    boxes.reserve(groups * kLanes * kBoxFloats);
    while (boxes.size() < groups * kLanes * kBoxFloats) {
      boxes.insert(boxes.end(), kNoBox.begin(), kNoBox.end());
    }
    for (size_t group = 0; group < groups; ++group) {
      const Box parent =
          FillGroup(&boxes[group * kLanes * kBoxFloats], &level[group * kGroupFloats]);
      parents.insert(parents.end(), parent.begin(), parent.end());
    }
    view_.boxes.levels[levels_.size() - 1] = level.data();
    view_.boxes.level_count = static_cast<int>(levels_.size());
    assert(levels_.size() <= PackedMesh::kMostLevels);
    boxes = std::move(parents);
  }
}

int64_t PackedSurface::ByteCount() const {
  size_t floats = frames_.size() + turned_boxes_.size() + corners_.size();
  for (const AlignedArray<float>& level : levels_) {
    floats += level.size();
  }
  return static_cast<int64_t>((floats + faces_.size()) * sizeof(float) + sizeof(*this));
}

}  // namespace cohort
