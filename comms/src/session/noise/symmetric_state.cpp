#include "session/noise/symmetric_state.hpp"

#include <algorithm>
#include <cassert>

namespace onemap::comms::noise {

namespace {
Key first_half(const Hash& hash) {
  Key key;
  std::copy_n(hash.begin(), kKeyBytes, key.bytes.begin());
  return key;
}
}  // namespace

SymmetricState::SymmetricState(std::string_view protocol_name) {
  assert(protocol_name.size() <= kHashBytes);  // longer ones would be hashed; ours is not
  std::copy(protocol_name.begin(), protocol_name.end(), hash_.begin());
  chaining_key_ = hash_;
}

void SymmetricState::set_key(const Hash& from) {
  key_ = first_half(from);
  has_key_ = true;
  counter_ = 0;
}

void SymmetricState::mix_hash(Bytes data) { hash_ = hash({hash_, data}); }

void SymmetricState::mix_key(Bytes input) {
  std::array<Hash, 2> out;
  hkdf(chaining_key_, input, out);
  chaining_key_ = out[0];
  set_key(out[1]);
  for (Hash& secret : out) wipe(secret);
}

void SymmetricState::mix_key_and_hash(Bytes input) {
  std::array<Hash, 3> out;
  hkdf(chaining_key_, input, out);
  chaining_key_ = out[0];
  mix_hash(out[1]);
  set_key(out[2]);
  for (Hash& secret : out) wipe(secret);
}

void SymmetricState::encrypt_and_hash(Bytes plain, MutableBytes sealed) {
  if (has_key_)
    seal(key_, 0, counter_++, hash_, plain, sealed);
  else
    std::copy(plain.begin(), plain.end(), sealed.begin());
  mix_hash(sealed);
}

bool SymmetricState::decrypt_and_hash(Bytes sealed, MutableBytes plain) {
  const Hash associated = hash_;
  mix_hash(sealed);  // before it is opened: both may be the same bytes
  if (has_key_) return open(key_, 0, counter_++, associated, sealed, plain);
  std::copy(sealed.begin(), sealed.end(), plain.begin());
  return true;
}

std::pair<Key, Key> SymmetricState::split() const {
  std::array<Hash, 2> out;
  hkdf(chaining_key_, {}, out);
  std::pair<Key, Key> keys{first_half(out[0]), first_half(out[1])};
  for (Hash& secret : out) wipe(secret);
  return keys;
}

}  // namespace onemap::comms::noise
