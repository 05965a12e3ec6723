#include "session/initiation.hpp"

#include <algorithm>
#include <cassert>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
Bytes last_mac(Bytes datagram) { return datagram.last(kMacBytes); }
}  // namespace

noise::Handshake begin_handshake(noise::Role role, const OwnSide& own, const TeamSecrets& team,
                                 const RandomBytes& random) {
  noise::Keys keys;
  keys.own_static = own.static_secret;
  keys.psk = team.psk;
  random(keys.own_ephemeral.bytes);
  const Bytes prologue(reinterpret_cast<const std::uint8_t*>(kPrologue.data()), kPrologue.size());
  return {noise::kProtocolName, noise::kXXpsk3, role, prologue, keys};
}

Initiation::Initiation(Instant now, std::uint32_t index, const OwnSide& own, const TeamSecrets& team,
                       const RandomBytes& random)
    : begun_(now), next_(now), index_(index), handshake_(begin_handshake(noise::Role::initiator, own, team, random)) {
  write_head(hello_, Type::hello);
  put_little_endian(&hello_[kHeadBytes], index);
  [[maybe_unused]] const bool written =
      handshake_.write({}, MutableBytes(hello_).subspan(kHelloNoiseAt, kHelloNoiseBytes));
  assert(written);  // a hello has no key of theirs in it
  const Mac mac = mac_of(team.mac.bytes, Bytes(hello_).first(kHelloMac1At));
  std::copy(mac.begin(), mac.end(), hello_.begin() + kHelloMac1At);
}

Refusal Initiation::read(Bytes answer, noise::Handshake& trial, Greeting& greeting) const {
  GreetingBytes bytes;
  if (!trial.read(answer.subspan(kNoiseAt, kAnswerNoiseBytes), bytes)) return Refusal::bad_handshake;
  const auto read = read_greeting(bytes, trial.their_static());
  if (!read) return Refusal::bad_identity;
  greeting = *read;
  return Refusal::count;
}

Refusal Initiation::read_answer(Bytes answer, Greeting& greeting) const {
  noise::Handshake trial = handshake_;
  return read(answer, trial, greeting);
}

bool Initiation::prove(Instant now, Bytes answer, const Greeting& greeting, const OwnSide& own,
                       const TeamSecrets& team) {
  GreetingBytes ignored;
  if (!handshake_.read(answer.subspan(kNoiseAt, kAnswerNoiseBytes), ignored)) return false;
  write_head(proof_, Type::proof);
  const std::uint32_t theirs = index_at(answer, kHeadBytes);
  put_little_endian(put_little_endian(&proof_[kHeadBytes], index_), theirs);
  if (!handshake_.write(own.greeting, MutableBytes(proof_).subspan(kNoiseAt, kProofNoiseBytes))) return false;
  const Mac mac = mac_of(team.mac.bytes, Bytes(proof_).first(kProofBytes - kMacBytes));
  std::copy(mac.begin(), mac.end(), proof_.end() - kMacBytes);
  std::ranges::copy(last_mac(answer), answer_mac_.begin());
  made_.emplace(now, Transport::Ends{noise::Role::initiator, index_, theirs, greeting}, handshake_);
  gap_ = kFirstGap;
  begun_ = next_ = now;  // the other side has as long to answer this as it had for the hello
  return true;
}

void Initiation::is_there(Instant now) { next_ = std::min(next_, std::max(now, said_ + kFirstGap)); }

bool Initiation::answered_by(Bytes answer) const {
  return made_ && equal_in_constant_time(last_mac(answer), answer_mac_);
}

bool Initiation::take_cookie(Bytes reply, const TeamSecrets& team, Mac& cookie) const {
  Mac mac1;
  std::copy_n(hello_.begin() + kHelloMac1At, mac1.size(), mac1.begin());
  const auto opened = open_cookie(reply, team.cookie, mac1);
  if (opened) cookie = *opened;
  return opened.has_value();
}

Bytes Initiation::take(Instant now, const std::optional<Mac>& cookie) {
  said_ = now;
  next_ = now + gap_;
  gap_ = std::min(2 * gap_, made_ ? kLongestProofGap : kLongestGap);
  if (made_) return proof_;
  if (cookie) pay(hello_, *cookie);
  return hello_;
}

}  // namespace onemap::comms
