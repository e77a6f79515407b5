#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <embree3/rtcore.h>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

struct Point {
  float x, y, z;
};
Point operator-(Point a, Point b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Point operator+(Point a, Point b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Point operator*(float s, Point a) {
  return {s * a.x, s * a.y, s * a.z};
}
float Dot(Point a, Point b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

Point At(const double* xyz, int64_t i) {
  const double* p = xyz + 3 * i;
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

/// Point of the triangle a b c that is nearest to p. Source: Ericson 2004, 5.1.5; Embree's tutorial
/// "closest point" does the same.
Point ClosestPoint(Point p, Point a, Point b, Point c) {
  const Point ab = b - a;
  const Point ac = c - a;
  const float d1 = Dot(ab, p - a);
  const float d2 = Dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const float d3 = Dot(ab, p - b);
  const float d4 = Dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  const float d5 = Dot(ab, p - c);
  const float d6 = Dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  }
  const float scale = 1 / (va + vb + vc);
  return a + (vb * scale) * ab + (vc * scale) * ac;
}

struct Search {
  const Point* vertices;
  const int32_t* corners;
  float best;
};

/// Embree calls this for each triangle whose box the shrinking sphere meets.
bool MeetTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto* search = static_cast<Search*>(arguments->userPtr);
  const int32_t* t = search->corners + 3 * static_cast<size_t>(arguments->primID);
  const Point p{arguments->query->x, arguments->query->y, arguments->query->z};
  const Point gap =
      p - ClosestPoint(p, search->vertices[t[0]], search->vertices[t[1]], search->vertices[t[2]]);
  const float squared_distance = Dot(gap, gap);
  if (squared_distance >= search->best) return false;
  search->best = squared_distance;
  arguments->query->radius = std::sqrt(squared_distance);
  return true;
}

class EmbreeRival : public SurfaceRival {
 public:
  EmbreeRival(PointList vertices, TriangleList triangles)
      : triangles_(triangles), device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    for (int64_t i = 0; i < vertices.count; ++i) {
      vertices_.push_back(At(vertices.xyz, i));
    }
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<Point*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Point), vertices_.size()));
    std::copy(vertices_.begin(), vertices_.end(), points);
    auto* corners = static_cast<int32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(int32_t), static_cast<size_t>(triangles.count)));
    std::copy_n(triangles.corners, 3 * triangles.count, corners);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
  }
  ~EmbreeRival() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeRival(const EmbreeRival&) = delete;
  EmbreeRival& operator=(const EmbreeRival&) = delete;

  void Find(PointList queries, double* squared_distances) const override {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    Search search{vertices_.data(), triangles_.corners, 0};
    for (int64_t i = 0; i < queries.count; ++i) {
      const Point p = At(queries.xyz, i);
      RTCPointQuery query{p.x, p.y, p.z, 0, std::numeric_limits<float>::infinity()};
      search.best = std::numeric_limits<float>::infinity();
      rtcPointQuery(scene_, &query, &context, MeetTriangle, &search);
      squared_distances[i] = static_cast<double>(search.best);
    }
  }

 private:
  TriangleList triangles_;
  RTCDevice device_;
  RTCScene scene_;
  std::vector<Point> vertices_;
};

}  // namespace

std::unique_ptr<SurfaceRival> MakeEmbree(PointList vertices, TriangleList triangles) {
  return std::make_unique<EmbreeRival>(vertices, triangles);
}

}  // namespace cohort
