#include "common/geometry/synthetic/capture.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "common/base/random.h"
#include "common/geometry/mesh/vertex_normals.h"
#include "common/geometry/synthetic/portable_math.h"
#include "common/geometry/synthetic/triangulate_patch.h"

namespace cohort {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLimit = 4.0;  // noise is truncated there, in standard deviations

// The mask covers an oval of the parameter domain.
constexpr double kOvalCenterV = -7.0;
constexpr double kOvalHalfWidth = 92.0;
constexpr double kOvalHalfHeight = 108.0;

/// Seeds of what is random in a capture, so that one does not shift the numbers of another.
enum Stream : uint64_t { kBorderStream = 1, kMeshStream, kNoiseStream, kOrderStream };

/// The border of one capture: an oval, cut in by a few mm along a random wavy line.
class BorderCurve {
 public:
  explicit BorderCurve(uint64_t seed) {
    Random random(StreamSeed(seed, kBorderStream, 0));
    inset_ = random.Uniform(2.0, 5.0);
    for (size_t k = 0; k < waves_.size(); ++k) {
      const bool fine = k >= 4;
      waves_[k] = {fine ? random.Uniform(0.15, 0.45) : random.Uniform(0.2, 1.2),
                   static_cast<double>(fine ? 14 + random.Below(40) : 2 + random.Below(7)),
                   random.Uniform(0.0, 2.0 * kPi)};
    }
  }

  [[nodiscard]] Eigen::Vector2d At(double t) const {
    const double angle = 2.0 * kPi * t;
    const double cosine = PortableCos(angle);
    const double sine = PortableSin(angle);
    const double a = cosine / kOvalHalfWidth;
    const double b = sine / kOvalHalfHeight;
    // Between an ellipse (exponent 2) and its fourth power: rounded, but with shoulders.
    const double ellipse = 1.0 / std::sqrt(a * a + b * b);
    const double square = 1.0 / std::sqrt(std::sqrt(a * a * a * a + b * b * b * b));
    double radius = 0.35 * ellipse + 0.65 * square - inset_;
    for (const Wave& wave : waves_) {
      radius -= wave.amplitude * PortableCos(wave.count * angle + wave.phase);
    }
    return {radius * cosine, kOvalCenterV + radius * sine};
  }

 private:
  struct Wave {
    double amplitude = 0;  // mm
    double count = 0;      // around the border, whole
    double phase = 0;
  };
  double inset_ = 0;
  std::array<Wave, 10> waves_;
};

/// Finer triangles where eyes, nose and mouth are.
double EdgeLengthAt(const Eigen::Vector2d& uv) {
  const double side = uv.x() < 0 ? -uv.x() : uv.x();
  const auto near = [&](double cu, double cv, double su, double sv) {
    const double du = (side - cu) / su;
    const double dv = (uv.y() - cv) / sv;
    return Gaussian(du * du + dv * dv);
  };
  const double detail = near(33, 28, 13, 8) + near(0, -8, 16, 15) + near(0, -41, 20, 9);
  return 1.0 / (0.75 + 0.75 * detail);
}

/// Smooth error of a scanner: a sum of plane waves with random directions, deviation 1.
class Warp {
 public:
  explicit Warp(Random& random) {
    for (Wave& wave : waves_) {
      Eigen::Vector3d direction;
      do {
        for (int axis = 0; axis < 3; ++axis) {
          direction(axis) = random.Uniform(-1.0, 1.0);
        }
      } while (direction.squaredNorm() > 1.0 || direction.squaredNorm() < 0.01);
      const double length = random.Uniform(25.0, 70.0);
      wave.direction = 2.0 * kPi / length * direction.normalized();
      wave.phase = random.Uniform(0.0, 2.0 * kPi);
    }
  }
  [[nodiscard]] double At(const Eigen::Vector3d& p) const {
    double sum = 0;
    for (const Wave& wave : waves_) {
      const double angle = wave.direction.x() * p.x() + wave.direction.y() * p.y() +
                           wave.direction.z() * p.z() + wave.phase;
      sum += PortableSin(angle);
    }
    return sum * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    Eigen::Vector3d direction;
    double phase = 0;
  };
  std::array<Wave, 16> waves_;
};

void AddNoise(TriangleMesh& mesh, uint64_t seed, const CaptureOptions& options) {
  Random random(StreamSeed(seed, kNoiseStream, 0));
  const Eigen::Matrix3Xd normals = VertexNormals(mesh);
  const Warp warp(random);
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) {
    const double error = options.warp * warp.At(mesh.vertices.col(i)) +
                         options.noise * TruncatedNormal(random, kLimit);
    mesh.vertices.col(i) += error * normals.col(i);
  }
}

std::vector<Eigen::Index> RandomOrder(Random& random, Eigen::Index count) {
  std::vector<Eigen::Index> order(static_cast<size_t>(count));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  for (size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<size_t>(random.Below(static_cast<int64_t>(i)))]);
  }
  return order;
}

/// The same mesh with vertices, faces and the corners of each face in another order.
TriangleMesh Shuffled(const TriangleMesh& mesh, uint64_t seed) {
  Random random(StreamSeed(seed, kOrderStream, 0));
  TriangleMesh shuffled;
  const std::vector<Eigen::Index> new_vertex = RandomOrder(random, mesh.vertices.cols());
  shuffled.vertices.resize(3, mesh.vertices.cols());
  for (size_t i = 0; i < new_vertex.size(); ++i) {
    shuffled.vertices.col(new_vertex[i]) = mesh.vertices.col(static_cast<Eigen::Index>(i));
  }
  const std::vector<Eigen::Index> new_face = RandomOrder(random, mesh.faces.cols());
  shuffled.faces.resize(3, mesh.faces.cols());
  for (size_t i = 0; i < new_face.size(); ++i) {
    const int64_t first = random.Below(3);
    for (int64_t k = 0; k < 3; ++k) {
      const int32_t vertex = mesh.faces((first + k) % 3, static_cast<Eigen::Index>(i));
      shuffled.faces(k, new_face[i]) =
          static_cast<int32_t>(new_vertex[static_cast<size_t>(vertex)]);
    }
  }
  return shuffled;
}

Eigen::Matrix3d RotationOf(const Eigen::Vector4d& q) {
  const double w = q(0);
  const double x = q(1);
  const double y = q(2);
  const double z = q(3);
  Eigen::Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

}  // namespace

TriangleMesh CaptureFace(const ProceduralFace& face, uint64_t seed, const CaptureOptions& options) {
  const BorderCurve border(seed);
  SurfacePatch patch;
  patch.point = [&](const Eigen::Vector2d& uv) { return face.Point(uv.x(), uv.y()); };
  patch.border = [&](double t) { return border.At(t); };
  patch.border_center = {0.0, kOvalCenterV};
  patch.edge_length = EdgeLengthAt;
  TriangleMesh mesh = TriangulatePatch(patch, options.vertices, StreamSeed(seed, kMeshStream, 0));
  AddNoise(mesh, seed, options);
  return Shuffled(mesh, seed);
}

CapturePose DrawPose(uint64_t seed, const PoseOptions& options) {
  Random random(seed);
  Eigen::Vector3d axis;
  do {
    for (int i = 0; i < 3; ++i) {
      axis(i) = random.Uniform(-1.0, 1.0);
    }
  } while (axis.squaredNorm() > 1.0 || axis.squaredNorm() < 0.01);
  axis = axis / std::sqrt(axis.x() * axis.x() + axis.y() * axis.y() + axis.z() * axis.z());
  const double half_angle = random.Uniform() * options.max_rotation_degrees * kPi / 360.0;
  CapturePose pose;
  pose.quaternion(0) = PortableCos(half_angle);
  pose.quaternion.tail<3>() = PortableSin(half_angle) * axis;
  Similarity& T = pose.T_file_canonical;
  T.rotation = RotationOf(pose.quaternion);
  T.scale = 1.0 + options.scale_sd * TruncatedNormal(random, 2.5);
  for (int i = 0; i < 3; ++i) {
    T.translation(i) = options.max_translation * random.Uniform(-1.0, 1.0);
  }
  return pose;
}

}  // namespace cohort
