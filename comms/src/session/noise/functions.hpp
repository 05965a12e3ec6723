#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "comms/secret.hpp"

// The functions of the suite 25519_ChaChaPoly_BLAKE2b (The Noise Protocol Framework, revision 34, section 12), by
// libsodium; HMAC and HKDF (RFC 2104, RFC 5869) over BLAKE2b are ours, because libsodium has them for SHA-2 only.
namespace onemap::comms::noise {

inline constexpr std::size_t kHashBytes = 64, kBlockBytes = 128, kKeyBytes = 32, kTagBytes = 16;
using Hash = std::array<std::uint8_t, kHashBytes>;
using Key = Secret32;

Hash hash(std::initializer_list<Bytes> parts);
Hash hmac(Bytes key, std::initializer_list<Bytes> parts);  // key: at most kBlockBytes
// Noise's HKDF: outputs.size() is 2 or 3.
void hkdf(const Hash& chaining_key, Bytes input, std::span<Hash> outputs);

using Public = std::array<std::uint8_t, 32>;
Public public_of(const Key& secret);
// False: the other side's point is of low order, and nothing may come of it.
[[nodiscard]] bool dh(const Key& secret, const Public& theirs, Key& shared);

// ChaCha20-Poly1305 (RFC 8439). The nonce is 32 bits of `domain` and the counter, little endian; Noise's domain is 0.
// sealed has plain.size() + kTagBytes; both may begin at the same byte.
void seal(const Key& key, std::uint32_t domain, std::uint64_t counter, Bytes associated, Bytes plain,
          MutableBytes sealed);
[[nodiscard]] bool open(const Key& key, std::uint32_t domain, std::uint64_t counter, Bytes associated, Bytes sealed,
                        MutableBytes plain);

}  // namespace onemap::comms::noise
