#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "hal/base/time.hpp"
#include "session/cookies.hpp"
#include "session/greeting.hpp"
#include "session/noise/handshake.hpp"
#include "session/team_secrets.hpp"
#include "session/transport.hpp"

namespace onemap::comms {

// What one robot brings to each of its handshakes.
struct OwnSide {
  noise::Key static_secret;
  StaticKey static_public{};
  GreetingBytes greeting{};
};

inline constexpr std::string_view kPrologue = "onemap 2";
noise::Handshake begin_handshake(noise::Role role, const OwnSide& own, const TeamSecrets& team,
                                 const RandomBytes& random);

// One attempt to make a session, from our side: hello, and after the answer the proof, again and again until something
// comes back. An attempt lasts five seconds; the next one has other keys.
class Initiation {
 public:
  static constexpr Duration kAttempt = std::chrono::seconds(5);
  static constexpr Duration kFirstGap = std::chrono::milliseconds(250), kLongestGap = std::chrono::seconds(4),
                            kLongestProofGap = std::chrono::seconds(1);

  Initiation(Instant now, std::uint32_t index, const OwnSide& own, const TeamSecrets& team, const RandomBytes& random);

  std::uint32_t index() const { return index_; }
  bool over(Instant now) const { return now - begun_ >= kAttempt; }
  const std::optional<Transport>& made() const { return made_; }
  std::optional<Transport>& made() { return made_; }

  // The answer to our hello; Refusal::count when it is good, and then `greeting` says whose. Nothing is remembered yet.
  Refusal read_answer(Bytes answer, Greeting& greeting) const;
  // That answer, read before, is believed: the session waits for a first sign from the other side.
  bool prove(Instant now, Bytes answer, const Greeting& greeting, const OwnSide& own, const TeamSecrets& team);
  // Whether this is the answer that made the session.
  bool answered_by(Bytes answer) const;
  bool take_cookie(Bytes reply, const TeamSecrets& team, Mac& cookie) const;

  Instant next() const { return next_; }
  // What is to be sent at next(), hello or proof; counts as sent.
  Bytes take(Instant now, const std::optional<Mac>& cookie);
  void send_soon(Instant now) { next_ = now; }
  void is_there(Instant now);  // it was heard: what was said last was lost, if that was a while ago
  void once_is_enough() { next_ = begun_ + kAttempt; }  // nobody answered before: this hello is not repeated

 private:
  Refusal read(Bytes answer, noise::Handshake& trial, Greeting& greeting) const;
  Instant begun_, next_;
  Instant said_{};
  Duration gap_ = kFirstGap;
  std::uint32_t index_;
  noise::Handshake handshake_;
  std::array<std::uint8_t, sealed::kHelloBytes> hello_{};
  std::array<std::uint8_t, sealed::kProofBytes> proof_{};
  Mac answer_mac_{};
  std::optional<Transport> made_;
};

}  // namespace onemap::comms
