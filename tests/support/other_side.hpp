#pragma once
// A member of the team, or somebody who would like to be one, made of the session layer's parts: it can say what an
// honest robot never would. It holds one handshake and one session with one Guard.
#include <algorithm>
#include <optional>
#include <vector>

#include "comms/guard.hpp"
#include "session/half_open.hpp"
#include "session/initiation.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

using Datagram = std::vector<std::uint8_t>;

class OtherSide {
 public:
  explicit OtherSide(const TeamKey& team, std::uint64_t seed = 99, const std::string& robot = "mallory")
      : team_(team), random_(seed), identity_(SecretSeed{static_cast<std::uint8_t>(seed), 7}) {
    fill(own_.static_secret.bytes);
    own_.static_public = noise::public_of(own_.static_secret);
    robot_ = RobotId::from_name(robot);
    own_.greeting = signed_greeting(identity_, own_.static_public, robot_, 1);
  }
  const RobotId& robot() const { return robot_; }
  const Identity& identity() const { return identity_; }
  OwnSide& own() { return own_; }
  const TeamSecrets& team() const { return team_; }
  RandomBytes random() {
    return [this](MutableBytes bytes) { fill(bytes); };
  }

  Datagram hello(Instant now, const std::optional<Mac>& cookie = {}) {
    initiation_.emplace(now, static_cast<std::uint32_t>(random_.next()) | 1u, own_, team_, random());
    const Bytes bytes = initiation_->take(now, cookie);
    return {bytes.begin(), bytes.end()};
  }
  Datagram hello_again(Instant now, const std::optional<Mac>& cookie = {}) {
    const Bytes bytes = initiation_->take(now, cookie);
    return {bytes.begin(), bytes.end()};
  }
  std::optional<Mac> cookie_in(Bytes reply) {
    Mac cookie;
    if (!initiation_->take_cookie(reply, team_, cookie)) return std::nullopt;
    return cookie;
  }
  // The proof for this answer; nothing when it is none.
  Datagram proof(Instant now, Bytes answer) {
    Greeting greeting;
    if (initiation_->read_answer(answer, greeting) != Refusal::count) return {};
    if (!initiation_->prove(now, answer, greeting, own_, team_)) return {};
    const Bytes bytes = initiation_->take(now, std::nullopt);
    return {bytes.begin(), bytes.end()};
  }
  Datagram sealed(Bytes frames, std::uint32_t counter) {
    Datagram out(frames.size() + sealed::kOverheadBytes);
    std::ranges::copy(frames, out.begin() + sealed::kHeaderBytes);
    initiation_->made()->seal(out, frames.size(), counter);
    return out;
  }
  Transport& session() { return *initiation_->made(); }
  Initiation& initiation() { return *initiation_; }

 private:
  void fill(MutableBytes bytes) {
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random_.next() >> 56);
  }
  TeamSecrets team_;
  test::Random random_;
  Identity identity_;
  RobotId robot_;
  OwnSide own_;
  std::optional<Initiation> initiation_;
};

}  // namespace onemap::comms::sim
