#include "session/half_open.hpp"

#include <algorithm>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

HalfOpen::HalfOpen(Instant now, const Endpoint& from, std::uint32_t index, const OwnSide& own, const TeamSecrets& team,
                   const RandomBytes& random)
    : begun_(now), from_(from), index_(index), handshake_(begin_handshake(noise::Role::responder, own, team, random)) {}

bool HalfOpen::begin(Bytes hello, const OwnSide& own, const TeamSecrets& team) {
  theirs_ = index_at(hello, kHeadBytes);
  std::copy_n(hello.begin() + kHelloMac1At, kMacBytes, hello_mac_.begin());
  if (!handshake_.read(hello.subspan(kHelloNoiseAt, kHelloNoiseBytes), {})) return false;
  write_head(answer_, Type::answer);
  put_little_endian(put_little_endian(&answer_[kHeadBytes], index_), theirs_);
  if (!handshake_.write(own.greeting, MutableBytes(answer_).subspan(kNoiseAt, kAnswerNoiseBytes))) return false;
  const Mac mac = mac_of(team.mac.bytes, Bytes(answer_).first(kAnswerBytes - kMacBytes));
  std::copy(mac.begin(), mac.end(), answer_.end() - kMacBytes);
  return true;
}

bool HalfOpen::begun_by(Bytes hello) const {
  return equal_in_constant_time(hello.subspan(kHelloMac1At, kMacBytes), hello_mac_);
}

// With a copy: whoever forges a proof does not end the handshake of the other.
Refusal HalfOpen::read_proof(Bytes proof, Greeting& greeting) {
  if (index_at(proof, kHeadBytes) != theirs_) return Refusal::bad_handshake;
  noise::Handshake trial = handshake_;
  GreetingBytes bytes;
  if (!trial.read(proof.subspan(kNoiseAt, kProofNoiseBytes), bytes)) return Refusal::bad_handshake;
  const auto read = read_greeting(bytes, trial.their_static());
  if (!read) return Refusal::bad_identity;
  greeting = *read;
  handshake_ = trial;
  return Refusal::count;
}

Transport HalfOpen::made(Instant now, const Greeting& greeting) const {
  return {now, {noise::Role::responder, index_, theirs_, greeting}, handshake_};
}

}  // namespace onemap::comms
