#pragma once
#include <optional>
#include <string_view>
#include <utility>

#include "session/noise/pattern.hpp"
#include "session/noise/symmetric_state.hpp"

namespace onemap::comms::noise {

enum class Role { initiator, responder };

// What one side brings to a handshake. Only what the pattern needs is looked at.
struct Keys {
  Key own_static, own_ephemeral;  // secret ones; the ephemeral one is used for this handshake alone
  Key psk;
  Public their_static{};  // when the pattern says that it is known
};

// Noise's HandshakeState (section 5.3) for any table of tokens. Small and copied: whoever reads a message that may be
// forged reads it with a copy, and keeps the copy when it was good.
class Handshake {
 public:
  Handshake(std::string_view protocol_name, const Pattern& pattern, Role role, Bytes prologue, const Keys& keys);

  bool over() const { return next_ == pattern_->size; }
  bool my_turn() const { return !over() && (next_ % 2 == 0) == (role_ == Role::initiator); }

  // Bytes of the next message around a payload.
  std::size_t overhead() const;
  // Writes the next message; `message` has payload.size() + overhead(). False: a key of theirs is of low order.
  [[nodiscard]] bool write(Bytes payload, MutableBytes message);
  // Reads the next message; payload has message.size() - overhead(). False: it is not what the other side would have
  // written, and this handshake is of no more use.
  [[nodiscard]] bool read(Bytes message, MutableBytes payload);

  const Public& their_static() const { return their_static_; }  // proved when over()
  const Hash& hash() const { return symmetric_.handshake_hash(); }
  std::pair<Key, Key> split() const { return symmetric_.split(); }  // the initiator's sending key, the responder's

 private:
  bool mix(Token token);
  void mix_public(const Public& key);
  SymmetricState symmetric_;
  const Pattern* pattern_;
  Role role_;
  Keys keys_;
  Public own_static_{}, own_ephemeral_{}, their_static_{}, their_ephemeral_{};
  std::size_t next_ = 0;
};

}  // namespace onemap::comms::noise
