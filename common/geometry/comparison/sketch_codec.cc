// The sketch half of distance_codec.h.

#include <algorithm>
#include <cmath>
#include <limits>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/geometry/comparison/distance_codec.h"

namespace cohort {
namespace {

constexpr std::string_view kName = "CDS1";

absl::Status Damaged(std::string_view what) {
  return absl::DataLossError("distance sketch: " + std::string(what));
}

/// 7 bits a byte, the lowest first; the top bit says that more follow.
void PutCount(ByteWriter& writer, uint32_t value) {
  while (value >= 0x80) {
    writer.Put(static_cast<uint8_t>(value | 0x80));
    value >>= 7;
  }
  writer.Put(static_cast<uint8_t>(value));
}

/// Only the shortest form counts, so that a sketch has one encoding.
bool GetCount(ByteReader& reader, uint32_t& value) {
  value = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    uint8_t byte = 0;
    if (!reader.Get(byte) || (shift == 28 && byte > 0x0F) || (shift > 0 && byte == 0)) {
      return false;
    }
    value |= uint32_t{byte & 0x7Fu} << shift;
    if (byte < 0x80) {
      return true;
    }
  }
  return false;
}

bool GetTotals(ByteReader& reader, FieldTotals& totals) {
  return reader.Get(totals.count) && reader.Get(totals.sum) && reader.Get(totals.sum_absolute) &&
         reader.Get(totals.sum_squares) && reader.Get(totals.squared_deviations) &&
         reader.Get(totals.log_mean) && reader.Get(totals.min) && reader.Get(totals.max) &&
         reader.Get(totals.min_absolute);
}

/// Whether x lies between the two, apart from rounding.
bool Between(double x, double low, double high) {
  const double slack = 1e-9 * std::max(std::abs(low), std::abs(high));
  return x >= low - slack && x <= high + slack;
}

absl::Status CheckTotals(const FieldTotals& totals, DistanceSign sign) {
  const auto n = static_cast<double>(totals.count);
  const double largest = std::max(-totals.min, totals.max);
  if (totals.count < 1 || totals.count > std::numeric_limits<int32_t>::max()) {
    return Damaged(absl::StrCat(totals.count, " values"));
  }
  if (!(totals.min <= totals.max && largest <= double{std::numeric_limits<float>::max()} &&
        totals.min_absolute >= 0 && totals.min_absolute <= largest)) {
    return Damaged(absl::StrCat("extremes ", totals.min, " to ", totals.max, ", |d| from ",
                                totals.min_absolute));
  }
  if (!Between(totals.sum, n * totals.min, n * totals.max) ||
      !Between(totals.sum_absolute, n * totals.min_absolute, n * largest) ||
      !Between(totals.sum_squares, n * totals.min_absolute * totals.min_absolute,
               n * largest * largest) ||
      !Between(totals.squared_deviations, 0, totals.sum_squares)) {
    return Damaged(absl::StrCat("sums ", totals.sum, ", ", totals.sum_absolute, ", ",
                                totals.sum_squares, ", ", totals.squared_deviations,
                                " do not fit the extremes"));
  }
  // |ln d| of floats is below 104; -infinity if and only if some d is 0.
  if (std::isnan(totals.log_mean) || totals.log_mean > 104 ||
      (totals.min_absolute == 0) != (totals.log_mean < -104)) {
    return Damaged(absl::StrCat("mean logarithm ", totals.log_mean));
  }
  if (sign == DistanceSign::kAbsolute &&
      (totals.min != totals.min_absolute || totals.sum != totals.sum_absolute)) {
    return Damaged("absolute distances with signs");
  }
  return absl::OkStatus();
}

absl::Status CheckBins(const DistanceSketch& sketch) {
  const FieldTotals& totals = sketch.totals;
  const double rms = std::sqrt(totals.sum_squares / static_cast<double>(totals.count));
  if (sketch.bin_width != SketchBinWidth(sketch.sign, std::max(-totals.min, totals.max), rms)) {
    return Damaged(absl::StrCat("bin width ", sketch.bin_width));
  }
  const auto bin_of = [&sketch](double value) {
    const double bin = std::floor(value / sketch.bin_width) - sketch.FirstBin();
    return static_cast<size_t>(std::clamp(bin, 0.0, kSketchBins - 1.0));
  };
  const size_t low = bin_of(totals.min);
  const size_t high = bin_of(totals.max);
  int64_t count = 0;
  for (size_t bin = 0; bin < sketch.bins.size(); ++bin) {
    count += int64_t{sketch.bins.at(bin)};
    if ((bin < low || bin > high) && sketch.bins.at(bin) != 0) {
      return Damaged(absl::StrCat("bin ", bin, " lies outside the extremes"));
    }
  }
  if (count != totals.count || sketch.bins.at(low) == 0 || sketch.bins.at(high) == 0) {
    return Damaged(absl::StrCat("the bins hold ", count, " of ", totals.count, " values"));
  }
  return absl::OkStatus();
}

}  // namespace

std::string EncodeSketch(const DistanceSketch& sketch) {
  ByteWriter writer;
  writer.PutBytes(kName);
  writer.Put(static_cast<uint8_t>(sketch.sign));
  const FieldTotals& totals = sketch.totals;
  writer.Put(totals.count);
  for (const double value :
       {totals.sum, totals.sum_absolute, totals.sum_squares, totals.squared_deviations,
        totals.log_mean, totals.min, totals.max, totals.min_absolute, sketch.bin_width}) {
    writer.Put(value);
  }
  const auto filled = [](uint32_t count) { return count != 0; };
  const auto first = std::find_if(sketch.bins.begin(), sketch.bins.end(), filled);
  const auto end = std::find_if(sketch.bins.rbegin(), sketch.bins.rend(), filled).base();
  writer.Put(static_cast<uint16_t>(first - sketch.bins.begin()));
  writer.Put(static_cast<uint16_t>(end - first));
  std::for_each(first, end, [&writer](uint32_t count) { PutCount(writer, count); });
  return std::move(writer).Take();
}

absl::StatusOr<DistanceSketch> DecodeSketch(std::string_view bytes) {
  if (bytes.substr(0, kName.size()) != kName) {
    return Damaged("the bytes do not begin with " + std::string(kName));
  }
  ByteReader reader(bytes.substr(kName.size()));
  DistanceSketch sketch;
  uint8_t sign = 0;
  uint16_t first = 0;
  uint16_t filled = 0;
  if (!reader.Get(sign) || !GetTotals(reader, sketch.totals) || !reader.Get(sketch.bin_width) ||
      !reader.Get(first) || !reader.Get(filled)) {
    return Damaged("it ends in its head");
  }
  if (sign > static_cast<uint8_t>(DistanceSign::kSigned)) {
    return Damaged(absl::StrCat("sign ", sign));
  }
  sketch.sign = static_cast<DistanceSign>(sign);
  if (filled == 0 || first + filled > kSketchBins) {
    return Damaged(absl::StrCat("bins ", first, " to ", first + filled, " of ", kSketchBins));
  }
  for (size_t bin = first; bin < size_t{first} + filled; ++bin) {
    if (!GetCount(reader, sketch.bins.at(bin))) {
      return Damaged(absl::StrCat("no count for bin ", bin));
    }
  }
  if (reader.Remaining() != 0 || sketch.bins.at(first) == 0 ||
      sketch.bins.at(size_t{first} + filled - 1) == 0) {
    return Damaged(absl::StrCat(reader.Remaining(), " bytes too many, or empty bins at its ends"));
  }
  COHORT_RETURN_IF_ERROR(CheckTotals(sketch.totals, sketch.sign));
  COHORT_RETURN_IF_ERROR(CheckBins(sketch));
  return sketch;
}

}  // namespace cohort
