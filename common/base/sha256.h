#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace cohort {

/// SHA-256 of some bytes as 64 lower-case hexadecimal characters; names a blob.
class Digest {
 public:
  /// The empty digest: "no blob".
  Digest() = default;

  /// @return kInvalidArgument unless `hex` is 64 characters of 0-9 and a-f.
  [[nodiscard]] static absl::StatusOr<Digest> FromHex(std::string_view hex);

  [[nodiscard]] const std::string& Hex() const { return hex_; }
  [[nodiscard]] bool empty() const { return hex_.empty(); }

  friend bool operator==(const Digest&, const Digest&) = default;
  friend auto operator<=>(const Digest&, const Digest&) = default;

 private:
  friend class Sha256;
  explicit Digest(std::string hex) : hex_(std::move(hex)) {}
  std::string hex_;
};

/// SHA-256 over a stream of pieces. Not thread-safe. Source: FIPS 180-4, computed by OpenSSL.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Update(std::string_view bytes);
  /// Ends the stream; no Update or Finish after it.
  [[nodiscard]] Digest Finish();

  /// Digest of one piece.
  [[nodiscard]] static Digest Of(std::string_view bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cohort

template <>
struct std::hash<cohort::Digest> {
  size_t operator()(const cohort::Digest& digest) const {
    return std::hash<std::string>()(digest.Hex());
  }
};
