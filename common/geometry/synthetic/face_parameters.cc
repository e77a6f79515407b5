#include "common/geometry/synthetic/face_parameters.h"

#include <cmath>
#include <cstddef>

#include "common/base/random.h"
#include "common/geometry/synthetic/portable_math.h"

namespace cohort {
namespace {

constexpr double kTruncation = 2.5;     // standard deviations
constexpr double kBumpDeviation = 1.7;  // mm per coordinate

struct IdentityRow {
  double FaceIdentity::*field;
  double deviation;  // mm
};

// Standard deviations in the order of the struct: the order is part of what a seed means.
constexpr std::array<IdentityRow, 38> kIdentity = {{
    {&FaceIdentity::head_width, 3.4},        {&FaceIdentity::head_depth, 4.5},
    {&FaceIdentity::upper_face_length, 3.5}, {&FaceIdentity::mid_face_length, 2.8},
    {&FaceIdentity::lower_face_length, 3.2}, {&FaceIdentity::forehead_slope, 4.2},
    {&FaceIdentity::forehead_bulge, 1.8},    {&FaceIdentity::temple, 1.6},
    {&FaceIdentity::brow_ridge, 1.3},        {&FaceIdentity::brow_height, 1.3},
    {&FaceIdentity::eye_distance, 1.5},      {&FaceIdentity::eye_size, 0.8},
    {&FaceIdentity::eye_tilt, 1.0},          {&FaceIdentity::socket_depth, 1.4},
    {&FaceIdentity::nose_length, 2.4},       {&FaceIdentity::nose_bridge, 1.6},
    {&FaceIdentity::nose_hump, 1.0},         {&FaceIdentity::nose_width, 0.8},
    {&FaceIdentity::tip_projection, 2.2},    {&FaceIdentity::tip_size, 0.8},
    {&FaceIdentity::alar_width, 1.2},        {&FaceIdentity::alar_size, 0.6},
    {&FaceIdentity::nostril, 0.7},           {&FaceIdentity::cheekbone, 2.0},
    {&FaceIdentity::cheekbone_height, 2.5},  {&FaceIdentity::cheek_fullness, 2.8},
    {&FaceIdentity::nasolabial_fold, 0.5},   {&FaceIdentity::philtrum, 0.35},
    {&FaceIdentity::upper_lip, 0.8},         {&FaceIdentity::lower_lip, 0.9},
    {&FaceIdentity::mouth_width, 1.8},       {&FaceIdentity::mouth_protrusion, 1.9},
    {&FaceIdentity::mental_crease, 0.8},     {&FaceIdentity::chin_projection, 2.8},
    {&FaceIdentity::chin_width, 2.5},        {&FaceIdentity::jaw_width, 3.4},
    {&FaceIdentity::jaw_angle, 3.5},         {&FaceIdentity::asymmetry, 0.7},
}};

struct ExpressionRow {
  double FaceExpression::*field;
  const char* name;
};

constexpr std::array<ExpressionRow, 6> kExpression = {{
    {&FaceExpression::smile, "smile"},
    {&FaceExpression::mouth_open, "mouth_open"},
    {&FaceExpression::brow_raise, "brow_raise"},
    {&FaceExpression::brow_furrow, "brow_furrow"},
    {&FaceExpression::cheek_puff, "cheek_puff"},
    {&FaceExpression::pout, "pout"},
}};

FaceBump DrawBump(Random& random, double spread) {
  FaceBump bump;
  bump.center.x() = random.Uniform(-70.0, 70.0);
  bump.center.y() = random.Uniform(-90.0, 95.0);
  bump.center.z() = -0.011 * bump.center.x() * bump.center.x();
  bump.width = random.Uniform(16.0, 42.0);
  for (int axis = 0; axis < 3; ++axis) {
    bump.offset(axis) = spread * kBumpDeviation * TruncatedNormal(random, kTruncation);
  }
  return bump;
}

}  // namespace

FaceParameters DrawPerson(uint64_t seed, double spread) {
  Random random(StreamSeed(seed, 1, 0));
  FaceParameters face;
  for (const IdentityRow& row : kIdentity) {
    face.identity.*row.field = spread * row.deviation * TruncatedNormal(random, kTruncation);
  }
  for (FaceBump& bump : face.bumps) {
    bump = DrawBump(random, spread);
  }
  return face;
}

FaceExpression DrawExpression(uint64_t seed, double strength) {
  Random random(StreamSeed(seed, 2, 0));
  FaceExpression expression;
  const auto count = static_cast<int64_t>(kExpression.size());
  const int64_t first = random.Below(count);
  const int64_t second = random.Below(count);
  expression.*kExpression[static_cast<size_t>(first)].field = strength * random.Uniform(0.5, 1.0);
  if (second != first) {
    expression.*kExpression[static_cast<size_t>(second)].field =
        0.5 * strength * random.Uniform(0.4, 1.0);
  }
  return expression;
}

std::string DescribeExpression(const FaceExpression& expression) {
  std::string text;
  for (const ExpressionRow& row : kExpression) {
    const auto hundredths = static_cast<int64_t>(std::floor(100.0 * (expression.*row.field) + 0.5));
    if (hundredths == 0) {
      continue;
    }
    const std::string digits = std::to_string(hundredths % 100);
    text += text.empty() ? "" : " + ";
    text += std::string(row.name) + " " + std::to_string(hundredths / 100) + "." +
            std::string(2 - digits.size(), '0') + digits;
  }
  return text.empty() ? "neutral" : text;
}

}  // namespace cohort
