#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>

namespace onemap::comms {

using PublicKey = std::array<std::uint8_t, 32>;  // Ed25519 (RFC 8032)
using Signature = std::array<std::uint8_t, 64>;  // Ed25519, detached
using SecretSeed =
    std::array<std::uint8_t, 32>;  // what a key pair is made of: kept in a file that only its robot reads

// The key pair that a robot signs with. It is made from its seed, so equal seeds are equal identities; copies share the
// secret, which is wiped with the last of them.
class Identity {
 public:
  explicit Identity(const SecretSeed& seed);

  const PublicKey& public_key() const { return public_key_; }
  Signature sign(std::span<const std::uint8_t> message) const;

 private:
  struct Secret;
  PublicKey public_key_{};
  std::shared_ptr<const Secret> secret_;
};

// Whether `signature` is what the holder of `key` wrote under `message`. Total: any bytes are an answer.
bool verify(const PublicKey& key, std::span<const std::uint8_t> message, const Signature& signature);

}  // namespace onemap::comms
