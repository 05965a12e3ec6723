#include "session/greeting.hpp"

#include <algorithm>
#include <string_view>

#include "comms/wire/header.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms {

namespace {
constexpr std::string_view kLabel = "onemap 2 static key";
using Signed = std::array<std::uint8_t, kLabel.size() + 32 + 16 + 8>;

Signed what_is_signed(const StaticKey& key, const RobotId& robot, std::uint64_t incarnation) {
  Signed out;
  auto at = std::copy(kLabel.begin(), kLabel.end(), out.begin());
  at = std::copy(key.begin(), key.end(), at);
  at = std::copy(robot.bytes.begin(), robot.bytes.end(), at);
  put_little_endian(&*at, incarnation);
  return out;
}
}  // namespace

GreetingBytes signed_greeting(const Identity& identity, const StaticKey& own, const RobotId& robot,
                              std::uint64_t incarnation) {
  GreetingBytes bytes;
  auto at = std::copy(robot.bytes.begin(), robot.bytes.end(), bytes.begin());
  put_little_endian(&*at, incarnation);
  at = std::copy(identity.public_key().begin(), identity.public_key().end(), at + 8);
  const Signature signature = identity.sign(what_is_signed(own, robot, incarnation));
  std::copy(signature.begin(), signature.end(), at);
  return bytes;
}

std::optional<Greeting> read_greeting(const GreetingBytes& bytes, const StaticKey& theirs) {
  Greeting greeting;
  Signature signature;
  ByteReader in(bytes);
  const auto copy = [&in](auto& to) { std::ranges::copy(in.bytes(to.size()), to.begin()); };
  copy(greeting.robot.bytes);
  greeting.incarnation = in.get<std::uint64_t>();
  copy(greeting.identity);
  copy(signature);
  if (!greeting.robot.valid() || !wire::is_life(greeting.incarnation)) return std::nullopt;
  if (!verify(greeting.identity, what_is_signed(theirs, greeting.robot, greeting.incarnation), signature))
    return std::nullopt;
  return greeting;
}

}  // namespace onemap::comms
