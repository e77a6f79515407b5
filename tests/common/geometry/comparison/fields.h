#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/random.h"

namespace cohort::testing {

/// A distance field with the name of its distribution.
using NamedField = std::pair<std::string, std::vector<float>>;

/// Like distances between two aligned faces, in mm: smooth along the vertices, most below 3, up to
/// 6 or so. Signed: the side changes every some vertices.
inline std::vector<float> FaceLikeField(int count, uint64_t seed) {
  Random random(seed);
  std::vector<float> field;
  double x = 0;
  double y = 0;
  double z = 0;
  for (int i = 0; i < count; ++i) {
    x = 0.97 * x + 0.3 * random.Normal();
    y = 0.97 * y + 0.3 * random.Normal();
    z = 0.97 * z + 0.3 * random.Normal();
    field.push_back(static_cast<float>(std::copysign(std::sqrt(x * x + y * y + z * z), z)));
  }
  return field;
}

inline std::vector<float> Absolute(std::vector<float> field) {
  for (float& value : field) {
    value = std::abs(value);
  }
  return field;
}

/// Signed fields of many shapes: what a search can give and what would break a histogram.
inline std::vector<NamedField> SignedFields(int count) {
  Random random(7);
  const auto make = [&random, count](auto value_of) {
    std::vector<float> field;
    field.reserve(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
      field.push_back(static_cast<float>(value_of(random)));
    }
    return field;
  };
  std::vector<NamedField> fields;
  fields.emplace_back("face", FaceLikeField(count, 3));
  fields.emplace_back("uniform", make([](Random& r) { return r.Uniform(-5, 5); }));
  fields.emplace_back("normal", make([](Random& r) { return r.Normal(); }));
  fields.emplace_back("one-sided", make([](Random& r) { return 7 + std::abs(r.Normal()); }));
  fields.emplace_back("behind", make([](Random& r) { return -7 - std::abs(r.Normal()); }));
  fields.emplace_back("heavy tail",
                      make([](Random& r) { return r.Normal() / (0.001 + std::abs(r.Normal())); }));
  fields.emplace_back("ties", make([](Random& r) { return std::floor(r.Uniform(-4, 4)) / 2; }));
  fields.emplace_back("metres", make([](Random& r) { return 0.001 * r.Normal(); }));
  fields.emplace_back("tiny", make([](Random& r) { return 1e-40 * r.Normal(); }));
  fields.emplace_back("huge", make([](Random& r) { return 1e18 * r.Normal(); }));
  fields.emplace_back("constant", std::vector<float>(static_cast<size_t>(count), 0.1F));
  fields.emplace_back("zero", std::vector<float>(static_cast<size_t>(count), 0.0F));
  std::vector<float> outlier = FaceLikeField(count, 4);
  outlier.back() = 1e6F;
  fields.emplace_back("outlier", outlier);
  return fields;
}

inline std::vector<NamedField> AbsoluteFields(int count) {
  std::vector<NamedField> fields = SignedFields(count);
  for (NamedField& field : fields) {
    field.second = Absolute(field.second);
  }
  return fields;
}

}  // namespace cohort::testing
