#include "common/base/gmac.h"

#include <array>
#include <cassert>

#include <openssl/evp.h>

namespace cohort {
namespace {

constexpr size_t kMostPerCall = size_t{1} << 30;  ///< OpenSSL counts in int.

const unsigned char* Bytes(std::string_view bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

}  // namespace

struct Gmac::State {
  EVP_CIPHER_CTX* context = EVP_CIPHER_CTX_new();
};

// OpenSSL's GCM fails only without memory or without the algorithm.
Gmac::Gmac() : state_(std::make_unique<State>()) {
  constexpr std::array<unsigned char, 16> kKey{};
  constexpr std::array<unsigned char, 12> kIv{};
  [[maybe_unused]] const int started =
      EVP_EncryptInit_ex(state_->context, EVP_aes_128_gcm(), nullptr, kKey.data(), kIv.data());
  assert(started == 1);
}

Gmac::~Gmac() {
  EVP_CIPHER_CTX_free(state_->context);
}

void Gmac::Update(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::string_view piece = bytes.substr(0, kMostPerCall);
    int size = 0;
    [[maybe_unused]] const int updated = EVP_EncryptUpdate(
        state_->context, nullptr, &size, Bytes(piece), static_cast<int>(piece.size()));
    assert(updated == 1);
    bytes.remove_prefix(piece.size());
  }
}

std::string Gmac::Finish() {
  std::array<unsigned char, kBytes> tag{};
  int size = 0;
  [[maybe_unused]] const int finished = EVP_EncryptFinal_ex(state_->context, tag.data(), &size);
  assert(finished == 1 && size == 0);
  [[maybe_unused]] const int got =
      EVP_CIPHER_CTX_ctrl(state_->context, EVP_CTRL_AEAD_GET_TAG, kBytes, tag.data());
  assert(got == 1);
  return {reinterpret_cast<const char*>(tag.data()), tag.size()};
}

}  // namespace cohort
