#include "common/geometry/synthetic/head_shape.h"

#include "common/geometry/synthetic/portable_math.h"

namespace cohort {
namespace {

constexpr double kArcRadius = 75.0;  // mm of u per radian

/// One row of the average head, from under the chin to the hairline.
struct ProfileRow {
  double v, y, z, half_width, depth, lift;
};
constexpr std::array<ProfileRow, HeadShape::kKnots> kAverage = {{
    {-130, -86, -48, 54, 55, 46},
    {-112, -86.5, -32, 54, 60, 44},
    {-98, -86, -18, 54, 66, 41},
    {-88, -82.5, -8.5, 54.5, 71, 36},
    {-76, -75, -2.5, 55.5, 75, 29},
    {-60, -60, -2, 58.5, 79, 18},
    {-40, -40, -1, 63, 82, 8},
    {-20, -20, -1, 67, 85, 3},
    {0, 0, -1.5, 70, 86, 0},
    {22, 22, -3, 72, 86, 0},
    {40, 40, -2, 72.5, 85, 0},
    {60, 60, -6, 72, 81, 0},
    {82, 81, -16, 69, 72, -1},
    {106, 99, -31, 61, 57, -2},
}};

template <size_t N>
std::array<double, N> Slopes(const std::array<double, N>& knots,
                             const std::array<double, N>& values) {
  std::array<double, N> slopes = {};
  for (size_t i = 0; i < N; ++i) {
    const size_t low = i == 0 ? 0 : i - 1;
    const size_t high = i + 1 == N ? i : i + 1;
    slopes[i] = (values[high] - values[low]) / (knots[high] - knots[low]);
  }
  return slopes;
}

}  // namespace

template <size_t N>
ProfileCurve<N>::ProfileCurve(const std::array<double, N>& knots,
                              const std::array<double, N>& values)
    : knots_(knots), values_(values), slopes_(Slopes(knots, values)) {}

template <size_t N>
double ProfileCurve<N>::At(double v) const {
  size_t i = 0;
  while (i + 2 < N && v >= knots_[i + 1]) {
    ++i;
  }
  const double step = knots_[i + 1] - knots_[i];
  const double t = (v - knots_[i]) / step;
  const double rest = 1.0 - t;
  return values_[i] * (1.0 + 2.0 * t) * rest * rest + step * slopes_[i] * t * rest * rest +
         values_[i + 1] * t * t * (3.0 - 2.0 * t) - step * slopes_[i + 1] * t * t * rest;
}

FaceLayout::FaceLayout(const FaceIdentity& identity) {
  eye_x = 31.5 + identity.eye_distance;
  eye_y = 29.0;
  brow_y = 42.0 + identity.brow_height;
  nose_base_y = -20.0 - 0.7 * identity.mid_face_length - 0.7 * identity.nose_length;
  nose_tip_y = nose_base_y + 11.5;
  mouth_y = -41.0 - identity.mid_face_length - 0.3 * identity.nose_length;
  mouth_half_width = 24.5 + identity.mouth_width;
  lower_shift = identity.mid_face_length + identity.lower_face_length;
  chin_y = -70.0 - identity.mid_face_length - 0.8 * identity.lower_face_length;
}

HeadShape::HeadShape(const FaceIdentity& identity, const FaceLayout& layout)
    : identity_(identity), layout_(layout) {
  std::array<double, kKnots> v = {}, y = {}, z = {}, half_width = {}, depth = {}, lift = {};
  for (size_t i = 0; i < kKnots; ++i) {
    const ProfileRow& row = kAverage[i];
    const double upper = SmoothStep(40.0, 110.0, row.v);
    const double to_mouth = 1.0 - SmoothStep(-45.0, 20.0, row.v);
    const double to_chin = 1.0 - SmoothStep(-85.0, -40.0, row.v);
    const double jaw = 1.0 - SmoothStep(-70.0, 10.0, row.v);
    v[i] = row.v;
    y[i] = row.y + upper * identity.upper_face_length - to_mouth * identity.mid_face_length -
           to_chin * identity.lower_face_length;
    z[i] = row.z - upper * identity.forehead_slope;
    half_width[i] =
        row.half_width + identity.head_width * (1.0 - 0.5 * jaw) + jaw * identity.jaw_width;
    depth[i] = row.depth + identity.head_depth;
    lift[i] = row.lift - jaw * to_chin * identity.jaw_angle;
  }
  height_ = {v, y};
  front_ = {v, z};
  half_width_ = {v, half_width};
  depth_ = {v, depth};
  lift_ = {v, lift};
}

Eigen::Vector3d HeadShape::Point(double u, double v) const {
  const double sine = PortableSin(u / kArcRadius);
  const double cosine = PortableCos(u / kArcRadius);
  const double x = half_width_.At(v) * sine;
  const double y = height_.At(v) + lift_.At(v) * sine * sine;
  const double z = front_.At(v) - depth_.At(v) * (1.0 - cosine);
  const double relief = Relief(x, y);
  // Under the chin the surface looks down: relief fades there, or it would fold.
  const double under = SmoothStep(-100.0, -82.0, v);
  return {x + 0.75 * relief * under * sine, y, z + relief * under * cosine};
}

double HeadShape::Relief(double x, double y) const {
  const FaceIdentity& id = identity_;
  const double side = x < 0 ? -x : x;
  double relief = 0;
  const auto add = [&](double amount, double cx, double cy, double sx, double sy) {
    const double dx = (side - cx) / sx;
    const double dy = (y - cy) / sy;
    relief += amount * Gaussian(dx * dx + dy * dy);
  };
  // Forehead and brow.
  add(1.5 + id.forehead_bulge, 18, 68, 24, 14);
  add(3.6 + id.brow_ridge, 24, layout_.brow_y + 0.5, 14, 5.5);
  add(1.6 + 0.6 * id.brow_ridge, 0, layout_.brow_y - 1, 9, 7);
  add(-2.0 + id.temple, 66, 52, 12, 16);
  // Sockets: the hollow, its deep inner corner, and the rim of bone outside.
  add(-7.5 - id.socket_depth, layout_.eye_x - 2, layout_.eye_y + 2, 12, 7.5);
  add(-3.0 - 0.4 * id.socket_depth, 15.5, layout_.eye_y + 2, 5.5, 7);
  add(2.4, layout_.eye_x + 20, layout_.eye_y + 4, 6, 10);
  relief += CheekRelief(side, y);
  // Mouth region stands out on the arch of the teeth, the chin on its bone.
  add(3.0 + id.mouth_protrusion, 0, layout_.mouth_y, 19, 14);
  add(-2.6 - id.mental_crease, 0, layout_.mouth_y - 15.5, 15, 4.8);
  add(6.0 + id.chin_projection, 0, layout_.chin_y, 15.0 + id.chin_width, 10.5);
  add(1.0, 8.0, layout_.chin_y - 1, 5.5, 6);
  return relief;
}

double HeadShape::CheekRelief(double side, double y) const {
  const FaceIdentity& id = identity_;
  double relief = 0;
  const auto add = [&](double amount, double cx, double cy, double sx, double sy) {
    const double dx = (side - cx) / sx;
    const double dy = (y - cy) / sy;
    relief += amount * Gaussian(dx * dx + dy * dy);
  };
  add(4.2 + id.cheekbone, 47, 7 + id.cheekbone_height, 14, 11);
  add(2.5 + 0.4 * id.cheekbone, 30, 4 + id.cheekbone_height, 10, 9);
  add(-2.0 + id.cheek_fullness, 46, -32, 14, 16);
  add(1.5 + 0.6 * id.cheek_fullness, 30, -22, 8, 10);
  add(1.0, 50, layout_.chin_y + 18, 12, 13);
  return relief;
}

template class ProfileCurve<HeadShape::kKnots>;

}  // namespace cohort
