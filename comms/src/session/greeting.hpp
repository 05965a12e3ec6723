#pragma once
#include <optional>

#include "comms/identity.hpp"
#include "comms/secret.hpp"
#include "hal/base/ids.hpp"
#include "session/sealed_wire.hpp"

namespace onemap::comms {

// What each side says about itself inside a handshake: 120 bytes. The identity's signature is about the static key that
// the handshake proves, the name and the life, so nobody else can say it with a static key of his own.
struct Greeting {
  RobotId robot;
  std::uint64_t incarnation = 0;
  PublicKey identity{};
  bool operator==(const Greeting&) const = default;
};
using GreetingBytes = std::array<std::uint8_t, sealed::kGreetingBytes>;
using StaticKey = std::array<std::uint8_t, 32>;  // X25519, public

GreetingBytes signed_greeting(const Identity& identity, const StaticKey& own, const RobotId& robot,
                              std::uint64_t incarnation);
// Nothing: malformed, or not signed by the identity that it names.
std::optional<Greeting> read_greeting(const GreetingBytes& bytes, const StaticKey& theirs);

}  // namespace onemap::comms
