#include "common/geometry/synthetic/face_motion.h"

#include "common/geometry/synthetic/portable_math.h"

namespace cohort {
namespace {

/// Gaussian of height 1 around (cx, cy) at (side, y), the same on both sides of the face.
double Bump(double side, double y, double cx, double cy, double sx, double sy) {
  const double dx = (side - cx) / sx;
  const double dy = (y - cy) / sy;
  return Gaussian(dx * dx + dy * dy);
}

/// Corners of the mouth go out, up and back, cheeks rise. `out` is +1 on the left, -1 on the right.
Eigen::Vector3d Smile(const FaceLayout& at, double out, double side, double y) {
  const double corner = Bump(side, y, at.mouth_half_width, at.mouth_y + 1.0, 11.0, 9.0);
  const double cheek = Bump(side, y, 38.0, at.mouth_y + 30.0, 13.0, 12.0);
  const double lips = Bump(side, y, 0.0, at.mouth_y, 14.0, 8.0);
  return {out * (6.0 * corner + 1.0 * cheek), 5.5 * corner + 2.5 * cheek - 0.5 * lips,
          -3.0 * corner + 3.6 * cheek - 2.0 * lips};
}

/// The jaw turns down and back below the mouth line; the gap between the lips lies deeper.
Eigen::Vector3d OpenMouth(const FaceLayout& at, double side, double y) {
  const double beyond = SmoothStep(0.7 * at.mouth_half_width, at.mouth_half_width + 16.0, side);
  const double width = 2.0 + 34.0 * beyond;
  const double below = 1.0 - SmoothStep(at.mouth_y - 0.5 * width, at.mouth_y + 0.5 * width, y);
  const double reach = side / (0.95 * at.mouth_half_width);
  const double span = reach < 1.0 ? (1.0 - reach * reach) * (1.0 - reach * reach) : 0.0;
  const double arc = 1.0 - SmoothStep(20.0, 75.0, side);
  const double gap = 4.0 * below * (1.0 - below) * span;
  const double drop = below * (0.35 * arc + 0.65 * (span + (1.0 - span) * 0.6) * arc);
  return {0.0, -11.0 * drop, -4.0 * drop - 7.0 * gap};
}

Eigen::Vector3d MoveBrows(
    const FaceExpression& expression, const FaceLayout& at, double out, double side, double y) {
  const double brow = Bump(side, y, 24.0, at.brow_y + 3.0, 20.0, 9.0);
  const double inner = Bump(side, y, 11.0, at.brow_y, 9.0, 8.0);
  const double root = Bump(side, y, 0.0, at.brow_y - 2.0, 5.0, 8.0);
  const double raise = 5.5 * expression.brow_raise * brow;
  const double furrow = expression.brow_furrow;
  return {-3.0 * out * furrow * inner, raise - 3.6 * furrow * inner,
          furrow * (1.8 * inner - 1.5 * root)};
}

}  // namespace

Eigen::Vector3d ExpressionMotion(const FaceExpression& expression,
                                 const FaceLayout& layout,
                                 const Eigen::Vector3d& p) {
  const double side = p.x() < 0 ? -p.x() : p.x();
  const double out = p.x() / (side + 4.0);  // a sign without a jump in the middle
  const double y = p.y();
  Eigen::Vector3d motion = MoveBrows(expression, layout, out, side, y);
  if (expression.smile != 0) {
    motion += expression.smile * Smile(layout, out, side, y);
  }
  if (expression.mouth_open != 0) {
    motion += expression.mouth_open * OpenMouth(layout, side, y);
  }
  const double puff = expression.cheek_puff * Bump(side, y, 42.0, layout.mouth_y + 7.0, 15.0, 15.0);
  motion += puff * Eigen::Vector3d(4.5 * out, 0.0, 5.5);
  const double pout = expression.pout * Bump(side, y, 0.0, layout.mouth_y, 17.0, 10.0);
  motion += pout * Eigen::Vector3d(-0.24 * p.x(), 0.0, 5.5);
  return motion;
}

}  // namespace cohort
