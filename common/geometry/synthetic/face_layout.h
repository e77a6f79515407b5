#pragma once

#include "common/geometry/synthetic/face_parameters.h"

namespace cohort {

/// Where the parts of one neutral face lie: face looks along +z, +y is up, mm. The nose tip of the
/// average face is at y = -8, the mouth at y = -40; x = 0 is the middle.
struct FaceLayout {
  explicit FaceLayout(const FaceIdentity& identity);

  double eye_x = 0;  ///< Of the pupil.
  double eye_y = 0;
  double brow_y = 0;
  double nose_base_y = 0;  ///< Where the nose meets the upper lip.
  double nose_tip_y = 0;
  double mouth_y = 0;
  double mouth_half_width = 0;
  double chin_y = 0;       ///< Most forward point of the chin.
  double lower_shift = 0;  ///< How much lower than the average the end of the chin is.
};

}  // namespace cohort
