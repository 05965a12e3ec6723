#pragma once
#include <array>
#include <cstdint>

#include "comms/endpoint.hpp"
#include "session/initiation.hpp"

namespace onemap::comms {

// A handshake that somebody else began, from our side: between our answer and the proof.
class HalfOpen {
 public:
  static constexpr Duration kLife = std::chrono::seconds(6);
  // `hello` has a good MAC. Whether answer() may be sent: false, it is none that our handshake can read.
  HalfOpen(Instant now, const Endpoint& from, std::uint32_t index, const OwnSide& own, const TeamSecrets& team,
           const RandomBytes& random);
  bool begin(Bytes hello, const OwnSide& own, const TeamSecrets& team);

  const Endpoint& from() const { return from_; }
  Instant begun() const { return begun_; }
  bool over(Instant now) const { return now - begun_ >= kLife; }
  bool begun_by(Bytes hello) const;
  Bytes answer() const { return answer_; }

  // The proof; Refusal::count when it is good, and then this handshake is over and `greeting` says who is there.
  Refusal read_proof(Bytes proof, Greeting& greeting);
  Transport made(Instant now, const Greeting& greeting) const;

 private:
  Instant begun_;
  Endpoint from_;
  std::uint32_t index_, theirs_ = 0;
  noise::Handshake handshake_;
  Mac hello_mac_{};
  std::array<std::uint8_t, sealed::kAnswerBytes> answer_{};
};

}  // namespace onemap::comms
