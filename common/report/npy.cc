#include "common/report/npy.h"

#include <bit>
#include <cassert>
#include <cstdint>
#include <cstring>

namespace cohort {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::string_view kVersion{"\x01\x00", 2};
constexpr size_t kPreludeSize = 10;  // Magic, version, uint16 length of the header.
constexpr size_t kAlignment = 64;

}  // namespace

std::string NpyHeader(Eigen::Index rows, Eigen::Index columns) {
  static_assert(std::endian::native == std::endian::little, "doubles are copied as they lie");
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                       std::to_string(rows) + ", " + std::to_string(columns) + "), }";
  const size_t used = kPreludeSize + header.size() + 1;
  header.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  header += '\n';
  std::string npy(kMagic);
  npy += kVersion;
  npy += static_cast<char>(header.size() & 0xff);
  npy += static_cast<char>(header.size() >> 8);
  return npy + header;
}

std::string MatrixNpy(const Eigen::Ref<const RowMajorMatrix>& values) {
  assert(values.outerStride() == values.cols());
  std::string npy = NpyHeader(values.rows(), values.cols());
  const size_t data_begin = npy.size();
  const size_t data_size = static_cast<size_t>(values.size()) * sizeof(double);
  npy.resize(data_begin + data_size);
  if (data_size > 0) std::memcpy(npy.data() + data_begin, values.data(), data_size);
  return npy;
}

std::string LabelsText(std::span<const std::string> labels) {
  std::string text;
  for (const std::string& label : labels) {
    for (const char c : label) text += c == '\n' || c == '\r' ? ' ' : c;
    text += '\n';
  }
  return text;
}

}  // namespace cohort
