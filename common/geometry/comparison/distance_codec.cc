#include "common/geometry/comparison/distance_codec.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/geometry/comparison/zstd_frame.h"

namespace cohort {
namespace {

constexpr std::string_view kVectorsName = "CDV1";
constexpr std::string_view kCompactName = "CDC1";
constexpr int64_t kMaxSteps = (1 << 22) - 1;  ///< Differences then fit three bytes with their sign.
constexpr double kMinStep = 0x1p-100;
constexpr double kMaxGivenStep = 0x1p40;
constexpr double kMaxStep = 0x1p80;  ///< After widening for values below kMaxDistance.
constexpr float kMaxDistance = 0x1p100F;

/// Byte k of every value, for each of the `count` lowest k, one plane after the other.
std::string BytePlanes(std::span<const uint32_t> values, size_t count) {
  std::string planes(count * values.size(), '\0');
  for (size_t plane = 0; plane < count; ++plane) {
    char* out = planes.data() + plane * values.size();
    for (size_t i = 0; i < values.size(); ++i) {
      out[i] = static_cast<char>(static_cast<uint8_t>(values[i] >> (8 * plane)));
    }
  }
  return planes;
}

/// Inverse of BytePlanes; planes.size() is a multiple of count.
std::vector<uint32_t> FromBytePlanes(std::string_view planes, size_t count) {
  std::vector<uint32_t> values(count, 0);
  for (size_t plane = 0; plane * count < planes.size(); ++plane) {
    const char* in = planes.data() + plane * count;
    for (size_t i = 0; i < count; ++i) {
      values[i] |= uint32_t{static_cast<uint8_t>(in[i])} << (8 * plane);
    }
  }
  return values;
}

std::string Encode(std::string_view name,
                   std::string_view head,
                   std::string_view planes,
                   size_t plane_size) {
  std::vector<std::string_view> parts;
  if (!head.empty()) {
    parts.push_back(head);
  }
  for (size_t at = 0; at < planes.size(); at += plane_size) {
    parts.push_back(planes.substr(at, plane_size));
  }
  return std::string(name) + CompressFrame(parts);
}

/// The content of a field's frame, if it is `head` bytes and min_planes to max_planes planes.
absl::StatusOr<std::string> DecodeFrame(std::string_view bytes,
                                        std::string_view name,
                                        size_t head,
                                        std::array<size_t, 2> planes,
                                        int64_t count) {
  if (count < 1 || bytes.substr(0, name.size()) != name) {
    return absl::DataLossError(absl::StrCat(
        "distance field of ", count, " values: the bytes do not begin with ", std::string(name)));
  }
  const std::string_view frame = bytes.substr(name.size());
  COHORT_ASSIGN_OR_RETURN(const size_t size, FrameContentSize(frame));
  const auto n = static_cast<size_t>(count);
  const size_t rest = size - head;
  if (size < head || rest % n != 0 || rest / n < planes[0] || rest / n > planes[1]) {
    return absl::DataLossError(absl::StrCat("distance field of ", count, " values: ", size,
                                            " bytes unpacked are not what they take"));
  }
  return DecompressFrame(frame, size);
}

uint32_t ZigZag(int32_t value) {
  return (static_cast<uint32_t>(value) << 1) ^ static_cast<uint32_t>(value >> 31);
}

int32_t UnZigZag(uint32_t value) {
  return static_cast<int32_t>((value >> 1) ^ (~(value & 1) + 1));
}

/// Half a step goes away from zero.
int64_t Steps(double distance, double step) {
  const double quotient = std::abs(distance) / step;
  auto steps = static_cast<int64_t>(quotient);
  // The difference is exact; std::lround would be a call for every value.
  steps += quotient - static_cast<double>(steps) >= 0.5 ? 1 : 0;
  return distance < 0 ? -steps : steps;
}

/// The step that the field is kept in.
absl::StatusOr<double> StepFor(std::span<const float> distances, const CompactOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (distances.empty()) {
    return absl::InvalidArgumentError("the distance field has no value");
  }
  float largest = 0;
  for (size_t i = 0; i < distances.size(); ++i) {
    if (!(std::abs(distances[i]) < kMaxDistance)) {
      return absl::InvalidArgumentError(absl::StrCat("value ", i, " of the distance field, ",
                                                     distances[i],
                                                     ", is not finite and below 2^100"));
    }
    largest = std::max(largest, std::abs(distances[i]));
  }
  double step = options.step;
  while (std::floor(double{largest} / step + 0.5) > static_cast<double>(kMaxSteps)) {
    step *= 2;
  }
  return step;
}

std::vector<int32_t> AllSteps(std::span<const float> distances, double step) {
  std::vector<int32_t> steps(distances.size());
  std::transform(distances.begin(), distances.end(), steps.begin(), [step](float distance) {
    return static_cast<int32_t>(Steps(double{distance}, step));
  });
  return steps;
}

/// What is coded: the values, or what each differs from the one before.
enum class Coded : uint8_t { kValues, kDifferences };

/// Differences, if they vary less than the values do: the entropy of either grows with the
/// logarithm of its mean deviation, by nearly the same constant.
Coded ChooseCoded(std::span<const int32_t> steps) {
  int64_t sum = 0;
  for (const int32_t value : steps) {
    sum += value;
  }
  const int64_t mean = sum / static_cast<int64_t>(steps.size());
  int64_t of_values = 0;
  int64_t of_differences = 0;
  int64_t previous = steps[0];
  for (const int32_t value : steps) {
    of_values += std::abs(value - mean);
    of_differences += std::abs(value - previous);
    previous = value;
  }
  return of_differences <= of_values ? Coded::kDifferences : Coded::kValues;
}

/// Ahead of the planes of a compact field: the step and what is coded.
constexpr size_t kCompactHeadBytes = sizeof(double) + 1;

/// The field behind the head and the planes, which are there.
absl::StatusOr<CompactField> UnpackCompact(std::string_view content, int64_t count) {
  CompactField field;
  std::memcpy(&field.step, content.data(), sizeof(field.step));
  if (!(field.step >= kMinStep && field.step <= kMaxStep)) {
    return absl::DataLossError(absl::StrCat("compact distances: step ", field.step));
  }
  const auto coded = static_cast<uint8_t>(content[sizeof(field.step)]);
  if (coded > static_cast<uint8_t>(Coded::kDifferences)) {
    return absl::DataLossError(absl::StrCat("compact distances: coding ", coded));
  }
  const std::string_view planes = content.substr(kCompactHeadBytes);
  int64_t previous = 0;
  field.distances.reserve(static_cast<size_t>(count));
  for (const uint32_t code : FromBytePlanes(planes, static_cast<size_t>(count))) {
    const int64_t steps = previous + UnZigZag(code);
    if (std::abs(steps) > kMaxSteps) {
      return absl::DataLossError(absl::StrCat("compact distances: value ", field.distances.size(),
                                              " of ", count, " is ", steps, " steps"));
    }
    field.distances.push_back(static_cast<float>(static_cast<double>(steps) * field.step));
    previous = coded == static_cast<uint8_t>(Coded::kDifferences) ? steps : 0;
  }
  return field;
}

}  // namespace

std::string EncodeVectors(std::span<const float> distances) {
  assert(!distances.empty());
  std::vector<uint32_t> bits(distances.size());
  std::memcpy(bits.data(), distances.data(), distances.size_bytes());
  return Encode(kVectorsName, "", BytePlanes(bits, sizeof(float)), bits.size());
}

absl::StatusOr<std::vector<float>> DecodeVectors(std::string_view bytes, int64_t count) {
  COHORT_ASSIGN_OR_RETURN(const std::string content,
                          DecodeFrame(bytes, kVectorsName, 0, {4, 4}, count));
  const std::vector<uint32_t> bits = FromBytePlanes(content, static_cast<size_t>(count));
  std::vector<float> distances(bits.size());
  std::memcpy(distances.data(), bits.data(), bits.size() * sizeof(float));
  return distances;
}

absl::Status CompactOptions::Validate() const {
  if (!(step >= kMinStep && step <= kMaxGivenStep)) {
    return absl::InvalidArgumentError(
        absl::StrCat("step ", step, " of compact distances is not within 2^-100 to 2^40"));
  }
  return absl::OkStatus();
}

double CompactStep(double diagonal) {
  assert(diagonal > 0);
  // Decimal literals are correctly rounded, repeated multiplication would not be.
  constexpr std::array<double, 12> kSteps = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4,
                                             1e-3, 1e-2, 1e-1, 1,    10,   100};
  size_t best = 0;
  while (best + 1 < kSteps.size() && diagonal >= kSteps.at(best + 1) * 1e5) {
    ++best;
  }
  return kSteps.at(best);
}

absl::StatusOr<std::string> EncodeCompact(std::span<const float> distances,
                                          const CompactOptions& options) {
  COHORT_ASSIGN_OR_RETURN(const double step, StepFor(distances, options));
  const std::vector<int32_t> steps = AllSteps(distances, step);
  const Coded coded = ChooseCoded(steps);
  std::vector<uint32_t> codes(steps.size());
  uint32_t all_bits = 0;
  int32_t previous = 0;
  for (size_t i = 0; i < steps.size(); ++i) {
    codes[i] = ZigZag(steps[i] - previous);
    all_bits |= codes[i];
    previous = coded == Coded::kDifferences ? steps[i] : 0;
  }
  const size_t planes = all_bits < (1u << 8) ? 1 : all_bits < (1u << 16) ? 2 : 3;
  ByteWriter head;
  head.Put(step);
  head.Put(static_cast<uint8_t>(coded));
  return Encode(kCompactName, std::move(head).Take(), BytePlanes(codes, planes), codes.size());
}

absl::StatusOr<CompactField> DecodeCompact(std::string_view bytes, int64_t count) {
  COHORT_ASSIGN_OR_RETURN(const std::string content,
                          DecodeFrame(bytes, kCompactName, kCompactHeadBytes, {1, 3}, count));
  return UnpackCompact(content, count);
}

absl::StatusOr<CompactField> RoundCompact(std::span<const float> distances,
                                          const CompactOptions& options) {
  CompactField field;
  COHORT_ASSIGN_OR_RETURN(field.step, StepFor(distances, options));
  field.distances.reserve(distances.size());
  for (const float distance : distances) {
    const auto steps = static_cast<double>(Steps(double{distance}, field.step));
    field.distances.push_back(static_cast<float>(steps * field.step));
  }
  return field;
}

}  // namespace cohort
