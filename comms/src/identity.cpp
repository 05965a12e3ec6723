#include "comms/identity.hpp"

#include <sodium.h>

namespace onemap::comms {

static_assert(std::tuple_size_v<PublicKey> == crypto_sign_PUBLICKEYBYTES);
static_assert(std::tuple_size_v<Signature> == crypto_sign_BYTES);
static_assert(std::tuple_size_v<SecretSeed> == crypto_sign_SEEDBYTES);

struct Identity::Secret {
  std::array<std::uint8_t, crypto_sign_SECRETKEYBYTES> key{};
  Secret() = default;
  ~Secret() { sodium_memzero(key.data(), key.size()); }
  Secret(const Secret&) = delete;
  Secret& operator=(const Secret&) = delete;
};

Identity::Identity(const SecretSeed& seed) {
  auto secret = std::make_shared<Secret>();
  crypto_sign_seed_keypair(public_key_.data(), secret->key.data(), seed.data());
  secret_ = std::move(secret);
}

Signature Identity::sign(std::span<const std::uint8_t> message) const {
  Signature signature;
  crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(), secret_->key.data());
  return signature;
}

bool verify(const PublicKey& key, std::span<const std::uint8_t> message, const Signature& signature) {
  return crypto_sign_verify_detached(signature.data(), message.data(), message.size(), key.data()) == 0;
}

}  // namespace onemap::comms
