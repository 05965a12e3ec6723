#include "session/noise/functions.hpp"

#include <sodium.h>

#include <algorithm>
#include <cassert>

#include "hal/base/bytes.hpp"

namespace onemap::comms::noise {

namespace {
using Nonce = std::array<std::uint8_t, crypto_aead_chacha20poly1305_IETF_NPUBBYTES>;

Nonce nonce_of(std::uint32_t domain, std::uint64_t counter) {
  Nonce nonce{};
  put_little_endian(put_little_endian(nonce.data(), domain), counter);
  return nonce;
}

class Hasher {
 public:
  Hasher() { crypto_generichash_blake2b_init(&state_, nullptr, 0, kHashBytes); }
  ~Hasher() { sodium_memzero(&state_, sizeof state_); }
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;
  void add(Bytes part) { crypto_generichash_blake2b_update(&state_, part.data(), part.size()); }
  Hash result() {
    Hash out;
    crypto_generichash_blake2b_final(&state_, out.data(), out.size());
    return out;
  }

 private:
  crypto_generichash_blake2b_state state_;
};
}  // namespace

Hash hash(std::initializer_list<Bytes> parts) {
  Hasher hasher;
  for (const Bytes part : parts) hasher.add(part);
  return hasher.result();
}

Hash hmac(Bytes key, std::initializer_list<Bytes> parts) {
  assert(key.size() <= kBlockBytes);
  constexpr std::uint8_t kInner = 0x36, kOuter = 0x5C;
  std::array<std::uint8_t, kBlockBytes> pad{};
  std::copy(key.begin(), key.end(), pad.begin());
  for (auto& byte : pad) byte ^= kInner;
  Hasher inner;
  inner.add(pad);
  for (const Bytes part : parts) inner.add(part);
  const Hash first = inner.result();
  for (auto& byte : pad) byte ^= kInner ^ kOuter;
  Hasher outer;
  outer.add(pad);
  outer.add(first);
  wipe(pad);
  return outer.result();
}

void hkdf(const Hash& chaining_key, Bytes input, std::span<Hash> outputs) {
  assert(outputs.size() == 2 || outputs.size() == 3);
  Hash temporary = hmac(chaining_key, {input});
  const Hash* before = nullptr;
  std::uint8_t number = 1;
  for (Hash& output : outputs) {
    output = hmac(temporary, {before == nullptr ? Bytes() : Bytes(*before), Bytes(&number, 1)});
    before = &output;
    ++number;
  }
  wipe(temporary);
}

Public public_of(const Key& secret) {
  Public out;
  crypto_scalarmult_base(out.data(), secret.bytes.data());
  return out;
}

bool dh(const Key& secret, const Public& theirs, Key& shared) {
  return crypto_scalarmult(shared.bytes.data(), secret.bytes.data(), theirs.data()) == 0;
}

void seal(const Key& key, std::uint32_t domain, std::uint64_t counter, Bytes associated, Bytes plain,
          MutableBytes sealed) {
  assert(sealed.size() == plain.size() + kTagBytes);
  crypto_aead_chacha20poly1305_ietf_encrypt(sealed.data(), nullptr, plain.data(), plain.size(), associated.data(),
                                            associated.size(), nullptr, nonce_of(domain, counter).data(),
                                            key.bytes.data());
}

bool open(const Key& key, std::uint32_t domain, std::uint64_t counter, Bytes associated, Bytes sealed,
          MutableBytes plain) {
  if (sealed.size() < kTagBytes || plain.size() != sealed.size() - kTagBytes) return false;
  return crypto_aead_chacha20poly1305_ietf_decrypt(plain.data(), nullptr, nullptr, sealed.data(), sealed.size(),
                                                   associated.data(), associated.size(),
                                                   nonce_of(domain, counter).data(), key.bytes.data()) == 0;
}

}  // namespace onemap::comms::noise
