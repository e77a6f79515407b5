#include "common/geometry/synthetic/face_features.h"

#include "common/geometry/synthetic/portable_math.h"

namespace cohort {
namespace {

double Square(double x) {
  return x * x;
}

/// Gaussian of height 1 around the origin.
double Bump(double dx, double dy, double sx, double sy) {
  return Gaussian(Square(dx / sx) + Square(dy / sy));
}

}  // namespace

double FaceFeatures::Height(const Eigen::Vector3d& head) const {
  const double x = head.x();
  const double y = head.y();
  const double side = x < 0 ? -x : x;
  double z = WithEyes(side, y, head.z());
  z = WithNose(x, y, z);
  return WithMouth(x, y, z);
}

double FaceFeatures::WithEyes(double side, double y, double z) const {
  const double across = side - layout_.eye_x;
  const double up = y - layout_.eye_y - 0.07 * across * (1.0 + 0.9 * identity_.eye_tilt);
  // The lids lie on the eyeball: a cap that grows out of the socket.
  const double bend = Square(across / 15.5) + Square(up / 11.0);
  const double front = -11.5 + 0.8 * identity_.eye_size - 0.16 * across;
  const double ball = front - 7.2 * bend * (1.0 + 0.2 * bend);
  return SmoothMax(z, ball, 2.5) + LidRelief(across, up);
}

double FaceFeatures::LidRelief(double across, double up) const {
  const double window = 1.0 - SmoothStep(10.0, 18.0, across < 0 ? -across : across);
  const double arch = 1.0 - Square(across / 18.0);
  // The line where the closed lids meet lies low; the upper lid is the thicker one.
  const double slit = up + 1.2 + 2.6 * arch;
  const double crease = up - 1.8 - 4.2 * arch;
  const double line = -1.4 * Gaussian(Square(slit / 1.2));
  const double upper_lid = 1.1 * Gaussian(Square((slit - 2.2) / 1.5));
  const double lower_lid = 0.8 * Gaussian(Square((slit + 2.4) / 1.5));
  const double fold = -1.2 * Gaussian(Square(crease / 1.3));
  return window * (line + upper_lid + lower_lid + fold);
}

double FaceFeatures::RidgeHeight(double y) const {
  // From the root between the eyes (t = 0) to the tip (t = 1), then steeply down to the lip.
  const double root = layout_.eye_y + 9.0;
  const double t = (root - y) / (root - layout_.nose_tip_y);
  const double bridge = 7.0 + identity_.nose_bridge;
  const double tip = 20.5 + identity_.tip_projection;
  const double ridge = bridge * SmoothStep(-0.25, 0.5, t) +
                       (tip - bridge) * 1.12 * SmoothStep(-0.1, 1.25, t) +
                       (1.0 + identity_.nose_hump) * Bump(t - 0.48, 0, 0.16, 1);
  return ridge * (1.0 - SmoothStep(0.0, 12.0, layout_.nose_tip_y - 0.5 - y));
}

double FaceFeatures::WithNose(double x, double y, double z) const {
  const double side = x < 0 ? -x : x;
  const double root = layout_.eye_y + 9.0;
  const double down = SmoothStep(0.0, root - layout_.nose_tip_y, root - y);
  const double half_width = 5.8 + identity_.nose_width + 3.6 * down;
  const double q = Square(x / half_width);
  double out = z + RidgeHeight(y) * Gaussian(q + 0.06 * q * q);
  // Tip and wings are rounded bodies that grow out of the ridge.
  const double tip_radius = 9.5 + identity_.tip_size;
  const double tip_front = 22.0 + 1.05 * identity_.tip_projection;
  const double tip_bend = Square(x / tip_radius) + Square((y - layout_.nose_tip_y) / 8.0);
  out = SmoothMax(out, tip_front - 7.0 * tip_bend * (1.0 + 0.1 * tip_bend), 3.5);
  const double wing_x = side - 12.0 - identity_.alar_width;
  const double wing_y = y - layout_.nose_base_y - 6.6;
  const double size = 1.0 + 0.09 * identity_.alar_size;
  const double wing_bend = Square(wing_x / (5.6 * size)) + Square(wing_y / (6.2 * size));
  const double wing_front = 8.0 + 0.35 * identity_.tip_projection - 0.3 * wing_x;
  out = SmoothMax(out, wing_front - 6.5 * wing_bend * (1.0 + 0.1 * wing_bend), 4.0);
  // Nostrils open downwards, beside the columella.
  const double hole_x = side - 6.9 - 0.5 * identity_.alar_width;
  const double hole_y = y - layout_.nose_base_y - 2.8;
  out -= (5.0 + identity_.nostril) * Bump(hole_x, hole_y + 0.3 * hole_x, 2.9, 2.0);
  // The furrow between wing and cheek.
  return out - 0.8 * Bump(wing_x - 7.5, wing_y, 2.2, 6.0);
}

double FaceFeatures::WithMouth(double x, double y, double z) const {
  const double side = x < 0 ? -x : x;
  const double up = y - layout_.mouth_y;
  double out = z + LipRelief(side, up);
  // Philtrum: a groove between two low ridges.
  const double to_nose = layout_.nose_base_y - layout_.mouth_y;
  const double philtrum = Bump(0, up - 0.62 * to_nose, 1, 0.26 * to_nose);
  out += philtrum * (0.9 * Gaussian(Square((side - 5.0) / 2.2)) -
                     (1.3 + identity_.philtrum) * Gaussian(Square(side / 2.6)));
  // Corners of the mouth are drawn in.
  const double corner = layout_.mouth_half_width;
  out -= 2.2 * Bump(side - corner - 1.0, up + 0.5, 3.6, 3.6);
  // Fold from the wing of the nose past the corner of the mouth: distance to a slanted line.
  const double down =
      (layout_.nose_base_y + 6.0 - y) / (layout_.nose_base_y + 6.0 - layout_.mouth_y + 6.0);
  const double fold_x = 18.5 + identity_.alar_width + (corner + 8.5 - 18.5) * down;
  const double along = SmoothStep(-0.1, 0.25, down) * (1.0 - SmoothStep(0.6, 1.25, down));
  return out - (1.1 + identity_.nasolabial_fold) * along * Bump(side - fold_x, 0, 3.2, 1);
}

double FaceFeatures::LipRelief(double side, double up) const {
  const double reach = side / layout_.mouth_half_width;
  const double taper = reach < 1.0 ? 1.0 - reach * reach : 0.0;
  const double full = taper * (2.0 - taper);  // stays full longer than a parabola
  // The mouth line sags a little beside the middle.
  const double line = up + 0.9 * Bump(side - 9.0, 0, 6.0, 1) - 0.5 * Bump(side, 0, 3.5, 1);
  // Upper lip: cupid's bow peaks beside the middle.
  const double bow = 1.0 + 0.16 * Bump(side - 6.5, 0, 3.5, 1) - 0.10 * Bump(side, 0, 2.5, 1);
  const double upper_height = (8.0 + 0.9 * identity_.upper_lip) * bow * full + 0.6;
  const double lower_height = (9.5 + 0.9 * identity_.lower_lip) * full + 0.6;
  const double upper_out = (4.0 + 0.7 * identity_.upper_lip) * full;
  const double lower_out = (4.6 + 0.7 * identity_.lower_lip) * full;
  const double upper =
      upper_out * (1.0 - Square((line - 0.38 * upper_height) / (0.62 * upper_height)));
  const double lower_from = line + 0.5 * (up - line) * SmoothStep(0.0, 5.0, -line);
  const double lower =
      lower_out * (1.0 - Square((lower_from + 0.46 * lower_height) / (0.54 * lower_height)));
  const double inside = 1.0 - SmoothStep(0.75, 1.1, reach);
  const double lips = inside * SmoothMax(SmoothMax(upper, lower, 1.2), 0.0, 0.8);
  return lips - 2.4 * inside * Gaussian(Square(line / 1.3));
}

}  // namespace cohort
