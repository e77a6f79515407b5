#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <Eigen/Core>

namespace cohort {

/// How one person's face differs from the average face; all zero is the average face.
/// Lengths in mm, positive as the comment says.
struct FaceIdentity {
  double head_width = 0;         ///< Half width at the cheekbones, wider.
  double head_depth = 0;         ///< Front to the widest plane, deeper.
  double upper_face_length = 0;  ///< Brows to hairline, longer.
  double mid_face_length = 0;    ///< Eyes to mouth, longer.
  double lower_face_length = 0;  ///< Mouth to chin, longer.
  double forehead_slope = 0;     ///< Hairline further back.
  double forehead_bulge = 0;     ///< Middle of the forehead further out.
  double temple = 0;             ///< Temples fuller.
  double brow_ridge = 0;         ///< Bone over the eyes further out.
  double brow_height = 0;        ///< Brows higher.
  double eye_distance = 0;       ///< Half distance of the pupils, wider.
  double eye_size = 0;           ///< Eyeballs further out.
  double eye_tilt = 0;           ///< Outer corners of the eyes higher.
  double socket_depth = 0;       ///< Eye sockets deeper.
  double nose_length = 0;        ///< Tip lower.
  double nose_bridge = 0;        ///< Bridge higher.
  double nose_hump = 0;          ///< Middle of the bridge further out.
  double nose_width = 0;         ///< Bridge wider.
  double tip_projection = 0;     ///< Tip further out.
  double tip_size = 0;           ///< Tip rounder.
  double alar_width = 0;         ///< Wings further apart.
  double alar_size = 0;          ///< Wings bigger.
  double nostril = 0;            ///< Nostrils deeper.
  double cheekbone = 0;          ///< Cheekbones further out.
  double cheekbone_height = 0;   ///< Cheekbones higher.
  double cheek_fullness = 0;     ///< Cheeks fuller.
  double nasolabial_fold = 0;    ///< Fold from wing to mouth corner deeper.
  double philtrum = 0;           ///< Groove of the upper lip deeper.
  double upper_lip = 0;          ///< Upper lip fuller.
  double lower_lip = 0;          ///< Lower lip fuller.
  double mouth_width = 0;        ///< Half width, wider.
  double mouth_protrusion = 0;   ///< Mouth region further out.
  double mental_crease = 0;      ///< Crease between lower lip and chin deeper.
  double chin_projection = 0;    ///< Chin further out.
  double chin_width = 0;         ///< Chin wider.
  double jaw_width = 0;          ///< Half width at the angle of the jaw, wider.
  double jaw_angle = 0;          ///< Angle of the jaw lower.
  double asymmetry = 0;          ///< Nose, mouth and chin moved to the left side of the face.
};

/// What the face does; each 0 (not at all) to 1 (strongly).
struct FaceExpression {
  double smile = 0;
  double mouth_open = 0;
  double brow_raise = 0;
  double brow_furrow = 0;
  double cheek_puff = 0;
  double pout = 0;
};

/// One smooth local displacement: offset * exp(-|p - center|^2 / (2 width^2)), mm.
struct FaceBump {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  double width = 30;
};

/// Everything that determines the shape of one face.
struct FaceParameters {
  FaceIdentity identity;
  FaceExpression expression;
  /// What no named parameter says: wide and shallow bumps that make persons differ everywhere.
  std::array<FaceBump, 16> bumps;
};

/// Draws a person: every identity parameter from a normal distribution truncated at 2.5 standard
/// deviations, and the bumps. Neutral expression.
///
/// @param spread  factor on all standard deviations; 1 is a plausible population, 0 the average.
[[nodiscard]] FaceParameters DrawPerson(uint64_t seed, double spread);

/// Draws one or two expressions of random size.
///
/// @param strength  factor on the size, 0..1; 0 is neutral.
[[nodiscard]] FaceExpression DrawExpression(uint64_t seed, double strength);

/// For people, e.g. "neutral", "smile 0.62 + brow_raise 0.30". No comma, no quote.
[[nodiscard]] std::string DescribeExpression(const FaceExpression& expression);

}  // namespace cohort
