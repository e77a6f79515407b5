#include "common/base/sha256.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include <openssl/evp.h>

namespace cohort {

absl::StatusOr<Digest> Digest::FromHex(std::string_view hex) {
  const bool valid = hex.size() == 64 && std::all_of(hex.begin(), hex.end(), [](char c) {
                       return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
                     });
  if (!valid) {
    return absl::InvalidArgumentError("not a SHA-256 in hexadecimal: '" +
                                      std::string(hex.substr(0, 80)) + "'");
  }
  return Digest(std::string(hex));
}

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
};

// OpenSSL's SHA-256 fails only without memory or without the algorithm: the asserts keep a wrong
// digest from naming anything.
Sha256::Sha256() : state_(std::make_unique<State>()) {
  [[maybe_unused]] const int started = EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr);
  assert(started == 1);
}

Sha256::~Sha256() {
  EVP_MD_CTX_free(state_->context);
}

void Sha256::Update(std::string_view bytes) {
  [[maybe_unused]] const int updated =
      EVP_DigestUpdate(state_->context, bytes.data(), bytes.size());
  assert(updated == 1);
}

Digest Sha256::Finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> raw{};
  unsigned int size = 0;
  [[maybe_unused]] const int finished = EVP_DigestFinal_ex(state_->context, raw.data(), &size);
  assert(finished == 1 && size == 32);
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  std::string hex;
  hex.reserve(2 * static_cast<size_t>(size));
  for (unsigned int i = 0; i < size; ++i) {
    hex.push_back(kHexDigits[raw[i] >> 4]);
    hex.push_back(kHexDigits[raw[i] & 15]);
  }
  return Digest(std::move(hex));
}

Digest Sha256::Of(std::string_view bytes) {
  Sha256 hash;
  hash.Update(bytes);
  return hash.Finish();
}

}  // namespace cohort
