#include "common/report/render/rasterizer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "common/geometry/mesh/vertex_normals.h"

namespace cohort {
namespace {

// Directions in the camera's frame (x right, y up, z towards the viewer); unit vectors.
const Eigen::Vector3d kLamp = Eigen::Vector3d(-2, 3, 6) / 7;  // Exactly of length 7.
// How much of its colour a surface gives back, wherever it looks, to the lamp and to the front;
// and what of white is added.
struct Lighting {
  double ambient;
  double lamp;
  double front;
  double shine;
};
constexpr Lighting kPlaster = {0.24, 0.52, 0.26, 0.10};
constexpr Lighting kColored = {0.50, 0.32, 0.18, 0.04};  // Flatter: colours are to be read.
constexpr double kCloudLight = 0.8;                      // Points have no normals.
constexpr double kBackShare = 0.55;  // Of the light that a back side gives back.
constexpr double kPointSide = 1.6;   // Of a point's square, in mean distances between points.

constexpr int32_t kNothing = -1;

// What is seen at one sample.
struct Sample {
  double depth = -std::numeric_limits<double>::infinity();
  int32_t face = kNothing;  // A vertex in a cloud.
  float b = 0;              // Share of the second and of the third corner.
  float c = 0;
};

class Raster {
 public:
  Raster(int width, int height)
      : width_(width),
        height_(height),
        samples_(static_cast<size_t>(width) * static_cast<size_t>(height)) {}

  [[nodiscard]] int Width() const { return width_; }
  [[nodiscard]] int Height() const { return height_; }
  Sample& At(int x, int y) {
    return samples_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
  }

 private:
  int width_;
  int height_;
  std::vector<Sample> samples_;
};

// Samples whose middles, at i + 0.5, lie in [low, high]; `end` of them there are.
struct Span {
  int begin = 0;
  int end = 0;
};
Span SamplesBetween(double low, double high, int count) {
  const double first = std::clamp(std::ceil(low - 0.5), 0.0, static_cast<double>(count));
  const double last = std::clamp(std::floor(high - 0.5) + 1, 0.0, static_cast<double>(count));
  return {static_cast<int>(first), static_cast<int>(last)};
}

// Twice the signed area of (a, b, p), seen from above.
double Cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

void DrawFace(const std::array<Eigen::Vector3d, 3>& corners, int32_t face, Raster& raster) {
  const auto& [a, b, c] = corners;
  const double area = Cross(a, b, c.x(), c.y());
  if (area == 0 || !std::isfinite(area)) return;
  const auto [left, right] = std::minmax({a.x(), b.x(), c.x()});
  const auto [top, bottom] = std::minmax({a.y(), b.y(), c.y()});
  const Span columns = SamplesBetween(left, right, raster.Width());
  const Span rows = SamplesBetween(top, bottom, raster.Height());
  for (int row = rows.begin; row < rows.end; ++row) {
    for (int column = columns.begin; column < columns.end; ++column) {
      const double x = column + 0.5;
      const double y = row + 0.5;
      // Shares of the corners; on an edge of two faces both take the sample: no gap between them.
      const double share_b = Cross(c, a, x, y) / area;
      const double share_c = Cross(a, b, x, y) / area;
      const double share_a = 1 - share_b - share_c;
      if (share_a < 0 || share_b < 0 || share_c < 0) continue;
      const double depth = share_a * a.z() + share_b * b.z() + share_c * c.z();
      Sample& sample = raster.At(column, row);
      if (depth > sample.depth) {
        sample = {depth, face, static_cast<float>(share_b), static_cast<float>(share_c)};
      }
    }
  }
}

void DrawPoint(const Eigen::Vector3d& point, double side, int32_t vertex, Raster& raster) {
  const Span columns = SamplesBetween(point.x() - side / 2, point.x() + side / 2, raster.Width());
  const Span rows = SamplesBetween(point.y() - side / 2, point.y() + side / 2, raster.Height());
  for (int row = rows.begin; row < rows.end; ++row) {
    for (int column = columns.begin; column < columns.end; ++column) {
      Sample& sample = raster.At(column, row);
      if (point.z() > sample.depth) sample = {point.z(), vertex, 0, 0};
    }
  }
}

// Projected points in samples, y down.
Eigen::Matrix3Xd InSamples(const TriangleMesh& mesh, const Camera& camera, const Raster& raster) {
  Eigen::Matrix3Xd points = camera.Project(mesh.vertices);
  points.row(0) = (points.row(0).array() + 1) * (0.5 * raster.Width());
  points.row(1) = (1 - points.row(1).array()) * (0.5 * raster.Height());
  return points;
}

void DrawAll(const TriangleMesh& mesh, const Eigen::Matrix3Xd& points, Raster& raster) {
  if (mesh.IsPointCloud()) {
    const Eigen::Vector3d extent = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
    const double spacing =
        std::sqrt(extent.x() * extent.y() / static_cast<double>(mesh.VertexCount()));
    const double side = std::max(kPointSide * spacing, 2.0);
    for (int64_t i = 0; i < mesh.VertexCount(); ++i) {
      DrawPoint(points.col(i), side, static_cast<int32_t>(i), raster);
    }
    return;
  }
  for (int64_t face = 0; face < mesh.FaceCount(); ++face) {
    DrawFace({points.col(mesh.faces(0, face)), points.col(mesh.faces(1, face)),
              points.col(mesh.faces(2, face))},
             static_cast<int32_t>(face), raster);
  }
}

// x^16: the width of the highlight of a matt surface.
double Sixteenth(double x) {
  const double x2 = x * x;
  const double x4 = x2 * x2;
  const double x8 = x4 * x4;
  return x8 * x8;
}

// Red, green and blue, 0..255, not rounded.
Eigen::Vector3d Shade(const Eigen::Vector3d& color,
                      Eigen::Vector3d normal,
                      const Lighting& lighting) {
  const double length = normal.norm();
  if (length <= 0) return color;
  normal /= length;
  const bool is_back = normal.z() < 0;
  if (is_back) normal = -normal;
  const Eigen::Vector3d half = (kLamp + Eigen::Vector3d::UnitZ()).normalized();
  const double lamp = std::max(0.0, normal.dot(kLamp));
  const double light = lighting.ambient + lighting.lamp * lamp + lighting.front * normal.z();
  const double shine = lighting.shine * 255 * Sixteenth(std::max(0.0, normal.dot(half)));
  const Eigen::Vector3d front = color * light + Eigen::Vector3d::Constant(shine);
  return is_back ? Eigen::Vector3d(front * kBackShare) : front;
}

// Looks up what a sample shows.
class Shader {
 public:
  Shader(const TriangleMesh& mesh, std::span<const Rgb> colors, const Camera& camera)
      : mesh_(mesh),
        colors_(colors),
        normals_(mesh.IsPointCloud()
                     ? Eigen::Matrix3Xd()
                     : Eigen::Matrix3Xd(camera.R_camera_mesh * VertexNormals(mesh))) {}

  [[nodiscard]] Eigen::Vector3d ColorOf(const Sample& sample) const {
    if (mesh_.IsPointCloud()) return VertexColor(sample.face) * kCloudLight;
    const double b = sample.b;
    const double c = sample.c;
    const double a = 1 - b - c;
    const auto corners = mesh_.faces.col(sample.face);
    const Eigen::Vector3d normal =
        a * normals_.col(corners(0)) + b * normals_.col(corners(1)) + c * normals_.col(corners(2));
    const Eigen::Vector3d color =
        a * VertexColor(corners(0)) + b * VertexColor(corners(1)) + c * VertexColor(corners(2));
    return Shade(color, normal, colors_.empty() ? kPlaster : kColored);
  }

 private:
  [[nodiscard]] Eigen::Vector3d VertexColor(int32_t vertex) const {
    const Rgb color = colors_.empty() ? kPlasterColor : colors_[static_cast<size_t>(vertex)];
    return {static_cast<double>(color.red), static_cast<double>(color.green),
            static_cast<double>(color.blue)};
  }

  const TriangleMesh& mesh_;
  std::span<const Rgb> colors_;
  Eigen::Matrix3Xd normals_;  // In the camera's frame.
};

uint8_t ToByte(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

Rgb MeanOfPixel(int x, int y, const Shader& shader, const RenderOptions& options, Raster& raster) {
  const Eigen::Vector3d background(options.background.red, options.background.green,
                                   options.background.blue);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int row = 0; row < options.samples; ++row) {
    for (int column = 0; column < options.samples; ++column) {
      const Sample& sample = raster.At(x * options.samples + column, y * options.samples + row);
      const Eigen::Vector3d seen = sample.face == kNothing ? background : shader.ColorOf(sample);
      sum += seen.cwiseMin(255.0);
    }
  }
  sum /= options.samples * options.samples;
  return {ToByte(sum.x()), ToByte(sum.y()), ToByte(sum.z())};
}

}  // namespace

Image RenderMesh(const TriangleMesh& mesh,
                 std::span<const Rgb> colors,
                 const Camera& camera,
                 const RenderOptions& options) {
  assert(mesh.VertexCount() >= 1 && options.width >= 1 && options.height >= 1);
  assert(options.samples >= 1 && options.samples <= 8);
  assert(colors.empty() || std::ssize(colors) == mesh.VertexCount());
  Raster raster(options.width * options.samples, options.height * options.samples);
  DrawAll(mesh, InSamples(mesh, camera, raster), raster);
  const Shader shader(mesh, colors, camera);
  Image image{options.width, options.height, {}};
  image.pixels.reserve(static_cast<size_t>(options.width) * static_cast<size_t>(options.height));
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      image.pixels.push_back(MeanOfPixel(x, y, shader, options, raster));
    }
  }
  return image;
}

}  // namespace cohort
