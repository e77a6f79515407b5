#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace cohort {

/// A check of 128 bits over a stream of pieces, with a fixed key: some times faster than SHA-256,
/// for what is written and read often and never leaves the machine. It finds every accidental
/// change, but anyone can make bytes that fit it: nothing may be named by it. Not thread-safe.
/// Source: NIST SP 800-38D, computed by OpenSSL with AES-128, a key and an IV of zeros.
class Gmac {
 public:
  static constexpr size_t kBytes = 16;

  Gmac();
  ~Gmac();
  Gmac(const Gmac&) = delete;
  Gmac& operator=(const Gmac&) = delete;

  void Update(std::string_view bytes);
  /// Ends the stream; no Update or Finish after it. @return kBytes bytes.
  [[nodiscard]] std::string Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cohort
