#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace cohort {

static_assert(std::endian::native == std::endian::little, "our blobs are little-endian");

/// Appends little-endian numbers to a string; how blob formats are written.
class ByteWriter {
 public:
  template <typename T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <typename T>
  void PutArray(std::span<const T> values) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void PutBytes(std::string_view bytes) { bytes_.append(bytes); }
  /// A 64-bit length and the bytes.
  void PutString(std::string_view text) {
    Put(static_cast<uint64_t>(text.size()));
    bytes_.append(text);
  }
  [[nodiscard]] std::string Take() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what ByteWriter wrote. Every Get reports whether the bytes were there, so that no length
/// in a damaged blob is ever believed.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <typename T>
  [[nodiscard]] bool Get(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    if (rest_.size() < sizeof(T)) {
      return false;
    }
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return true;
  }
  template <typename T>
  [[nodiscard]] bool GetArray(std::span<T> values) {
    static_assert(std::is_arithmetic_v<T>);
    if (rest_.size() < values.size_bytes()) {
      return false;
    }
    if (values.empty()) {
      return true;  // memcpy must not see the null pointer of an empty span.
    }
    std::memcpy(values.data(), rest_.data(), values.size_bytes());
    rest_.remove_prefix(values.size_bytes());
    return true;
  }
  [[nodiscard]] bool GetString(std::string& text) {
    uint64_t size = 0;
    if (!Get(size) || size > rest_.size()) {
      return false;
    }
    text.assign(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return true;
  }
  [[nodiscard]] size_t Remaining() const { return rest_.size(); }
  [[nodiscard]] std::string_view Rest() const { return rest_; }

 private:
  std::string_view rest_;
};

}  // namespace cohort
