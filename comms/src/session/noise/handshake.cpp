#include "session/noise/handshake.hpp"

#include <algorithm>
#include <cassert>

namespace onemap::comms::noise {

namespace {
bool has(const Pattern& pattern, Token token) {
  for (const Message& message : pattern.messages)
    if (std::find(message.begin(), message.end(), token) != message.end()) return true;
  return false;
}
}  // namespace

Handshake::Handshake(std::string_view protocol_name, const Pattern& pattern, Role role, Bytes prologue,
                     const Keys& keys)
    : symmetric_(protocol_name),
      pattern_(&pattern),
      role_(role),
      keys_(keys),
      own_ephemeral_(public_of(keys.own_ephemeral)),
      their_static_(keys.their_static) {
  const bool own_known = role == Role::initiator ? pattern.initiator_known : pattern.responder_known;
  if (own_known || has(pattern, Token::s)) own_static_ = public_of(keys.own_static);
  symmetric_.mix_hash(prologue);
  const bool first = role == Role::initiator;
  if (pattern.initiator_known) symmetric_.mix_hash(first ? own_static_ : their_static_);
  if (pattern.responder_known) symmetric_.mix_hash(first ? their_static_ : own_static_);
}

std::size_t Handshake::overhead() const {
  assert(!over());
  bool key = symmetric_.has_key();
  std::size_t bytes = 0;
  for (const Token token : pattern_->messages[next_]) {
    if (token == Token::e) bytes += sizeof(Public);
    if (token == Token::s) bytes += sizeof(Public) + (key ? kTagBytes : 0);
    const bool keyless = token == Token::s || (token == Token::e && !pattern_->with_psk);
    key = key || !keyless;
  }
  return bytes + (key ? kTagBytes : 0);
}

void Handshake::mix_public(const Public& key) {
  symmetric_.mix_hash(key);
  if (pattern_->with_psk) symmetric_.mix_key(key);  // so that keys differ although the psk is the same (section 9.2)
}

bool Handshake::mix(Token token) {
  if (token == Token::psk) return symmetric_.mix_key_and_hash(keys_.psk.bytes), true;
  // The first letter is the initiator's key, the second the responder's.
  const bool first = role_ == Role::initiator;
  const bool static_of_initiator = token == Token::se || token == Token::ss;
  const bool static_of_responder = token == Token::es || token == Token::ss;
  const bool own = first ? static_of_initiator : static_of_responder;
  const bool theirs = first ? static_of_responder : static_of_initiator;
  Key shared;
  if (!dh(own ? keys_.own_static : keys_.own_ephemeral, theirs ? their_static_ : their_ephemeral_, shared))
    return false;
  symmetric_.mix_key(shared.bytes);
  return true;
}

bool Handshake::write(Bytes payload, MutableBytes message) {
  assert(my_turn() && message.size() == payload.size() + overhead());
  std::size_t at = 0;
  for (const Token token : pattern_->messages[next_]) {
    if (token == Token::e) {
      std::copy(own_ephemeral_.begin(), own_ephemeral_.end(), message.begin() + static_cast<std::ptrdiff_t>(at));
      at += own_ephemeral_.size();
      mix_public(own_ephemeral_);
    } else if (token == Token::s) {
      const std::size_t size = own_static_.size() + symmetric_.overhead();
      symmetric_.encrypt_and_hash(own_static_, message.subspan(at, size));
      at += size;
    } else if (!mix(token)) {
      return false;
    }
  }
  symmetric_.encrypt_and_hash(payload, message.subspan(at));
  ++next_;
  return true;
}

bool Handshake::read(Bytes message, MutableBytes payload) {
  if (over() || my_turn() || message.size() != payload.size() + overhead()) return false;
  std::size_t at = 0;
  for (const Token token : pattern_->messages[next_]) {
    if (token == Token::e) {
      std::copy_n(message.begin() + static_cast<std::ptrdiff_t>(at), their_ephemeral_.size(), their_ephemeral_.begin());
      at += their_ephemeral_.size();
      mix_public(their_ephemeral_);
    } else if (token == Token::s) {
      const std::size_t size = their_static_.size() + symmetric_.overhead();
      if (!symmetric_.decrypt_and_hash(message.subspan(at, size), their_static_)) return false;
      at += size;
    } else if (!mix(token)) {
      return false;
    }
  }
  if (!symmetric_.decrypt_and_hash(message.subspan(at), payload)) return false;
  ++next_;
  return true;
}

}  // namespace onemap::comms::noise
