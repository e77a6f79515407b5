#include "server/planning/ingest_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

constexpr size_t kNamedMeshes = 3;
constexpr char kAdvice[] =
    "; convert the files to one unit, or switch this check off with --size-ratio-limit 0";

struct SizedMesh {
  const std::string* name;
  double radius;
};

struct UnitGuess {
  double from;
  double to;
  const char* unit;
};
/// By how many times a length is off when its mesh is not in millimetres, with room for faces that
/// do differ.
constexpr std::array<UnitGuess, 3> kUnits = {
    {{5, 16, "centimetres"}, {16, 50, "inches"}, {300, 3000, "metres"}}};

/// " (metres?)" with a phrase before the unit, or nothing if no unit explains the ratio.
std::string GuessedUnit(double ratio, const char* phrase) {
  for (const UnitGuess& guess : kUnits) {
    if (ratio >= guess.from && ratio < guess.to) {
      return absl::StrCat(" (", phrase, guess.unit, "?)");
    }
  }
  return "";
}

/// Three digits, without an exponent where people do not expect one.
std::string Short(double value) {
  std::array<char, 64> text{};
  const bool whole = std::abs(value) >= 100 && std::abs(value) < 1e6;
  std::snprintf(text.data(), text.size(), whole ? "%.0f" : "%.3g", value);
  return text.data();
}

std::string Difference(const SizedMesh& a, const SizedMesh& b) {
  const auto& [small, large] =
      std::minmax(a, b, [](const SizedMesh& x, const SizedMesh& y) { return x.radius < y.radius; });
  const double ratio = large.radius / small.radius;
  return absl::StrCat(*small.name, " is ", Short(ratio), " times smaller than ", *large.name, " (",
                      Short(small.radius), " against ", Short(large.radius),
                      "): another unit of length", GuessedUnit(ratio, ""));
}

std::string Deviation(const SizedMesh& mesh, double median) {
  const bool smaller = mesh.radius < median;
  const double ratio = smaller ? median / mesh.radius : mesh.radius / median;
  return absl::StrCat(*mesh.name, " is ", Short(ratio), " times ", smaller ? "smaller" : "larger",
                      " than the median mesh (", Short(mesh.radius), " against ", Short(median),
                      "): another unit of length",
                      GuessedUnit(ratio, smaller ? "" : "the others in "));
}

std::string Deviations(const std::vector<SizedMesh>& meshes, double median) {
  std::string message;
  for (size_t i = 0; i < std::min(meshes.size(), kNamedMeshes); ++i) {
    absl::StrAppend(&message, i == 0 ? "" : "; ", Deviation(meshes[i], median));
  }
  if (meshes.size() > kNamedMeshes) {
    absl::StrAppend(&message, "; and ", meshes.size() - kNamedMeshes, " more");
  }
  return message;
}

}  // namespace

absl::Status CheckSizesFit(const PlanState& state) {
  const double limit = state.spec.size_ratio_limit;
  if (limit <= 0) {
    return absl::OkStatus();
  }
  std::vector<SizedMesh> sizes;
  std::vector<double> radii;
  for (const int32_t index : state.active) {
    const JobMesh& mesh = state.meshes[static_cast<size_t>(index)];
    sizes.push_back({&mesh.mesh.name, mesh.ingested->health.rms_radius});
    radii.push_back(sizes.back().radius);
  }
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>((radii.size() - 1) / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  const double median = *middle;
  const auto deviates = [limit, median](const SizedMesh& mesh) {
    return mesh.radius > limit * median || mesh.radius * limit < median;
  };
  std::vector<SizedMesh> deviating;
  std::copy_if(sizes.begin(), sizes.end(), std::back_inserter(deviating), deviates);
  if (deviating.empty()) {
    return absl::OkStatus();
  }
  const std::string problem =
      sizes.size() == 2 ? Difference(sizes[0], sizes[1]) : Deviations(deviating, median);
  return absl::FailedPreconditionError(problem + kAdvice);
}

}  // namespace cohort
