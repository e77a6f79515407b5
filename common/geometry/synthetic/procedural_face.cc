#include "common/geometry/synthetic/procedural_face.h"

#include "common/geometry/synthetic/face_motion.h"
#include "common/geometry/synthetic/portable_math.h"

namespace cohort {

ProceduralFace::ProceduralFace(const FaceParameters& parameters)
    : parameters_(parameters),
      layout_(parameters.identity),
      head_(parameters.identity, layout_),
      features_(parameters.identity, layout_) {}

Eigen::Vector3d ProceduralFace::Point(double u, double v) const {
  Eigen::Vector3d p = head_.Point(u, v);
  // Features belong to the front: under the chin their y coordinate means nothing.
  const double front = SmoothStep(-92.0, -78.0, v);
  if (front > 0) {
    p.z() += front * (features_.Height(p) - p.z());
  }
  p += ExpressionMotion(parameters_.expression, layout_, p);
  return Individual(p);
}

Eigen::Vector3d ProceduralFace::Individual(const Eigen::Vector3d& p) const {
  Eigen::Vector3d moved = p;
  for (const FaceBump& bump : parameters_.bumps) {
    const double dx = p.x() - bump.center.x();
    const double dy = p.y() - bump.center.y();
    const double dz = p.z() - bump.center.z();
    const double squared_distance = dx * dx + dy * dy + dz * dz;
    moved += Gaussian(squared_distance / (bump.width * bump.width)) * bump.offset;
  }
  const double down = (layout_.eye_y - p.y()) / 60.0;
  const double middle = Gaussian(p.x() * p.x() / 900.0);
  moved.x() += parameters_.identity.asymmetry * down * middle;
  return moved;
}

}  // namespace cohort
