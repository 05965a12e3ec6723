#pragma once
#include <string_view>
#include <utility>

#include "session/noise/functions.hpp"

namespace onemap::comms::noise {

// Noise's SymmetricState with its CipherState (sections 5.1 and 5.2): the transcript's hash, the chaining key, and the
// key that a handshake has so far.
class SymmetricState {
 public:
  explicit SymmetricState(std::string_view protocol_name);
  SymmetricState(const SymmetricState&) = default;
  SymmetricState& operator=(const SymmetricState&) = default;
  ~SymmetricState() { wipe(chaining_key_); }

  void mix_hash(Bytes data);
  void mix_key(Bytes input);
  void mix_key_and_hash(Bytes input);
  bool has_key() const { return has_key_; }
  std::size_t overhead() const { return has_key_ ? kTagBytes : 0; }
  // sealed has plain.size() + overhead(), and so on.
  void encrypt_and_hash(Bytes plain, MutableBytes sealed);
  [[nodiscard]] bool decrypt_and_hash(Bytes sealed, MutableBytes plain);
  const Hash& handshake_hash() const { return hash_; }
  std::pair<Key, Key> split() const;  // the initiator's sending key, and the responder's

 private:
  void set_key(const Hash& from);
  Hash chaining_key_{}, hash_{};
  Key key_;
  bool has_key_ = false;
  std::uint64_t counter_ = 0;
};

}  // namespace onemap::comms::noise
