#pragma once
#include <array>

#include "comms/secret.hpp"

namespace onemap::comms {

using Mac = std::array<std::uint8_t, 16>;

// What is derived from the team's key, each for one use: BLAKE2b-256 of a label, the team's key as its key.
struct TeamSecrets {
  explicit TeamSecrets(const TeamKey& team);
  Secret32 psk;     // of the Noise handshake
  Secret32 mac;     // of every handshake datagram: without it there is no answer
  Secret32 cookie;  // seals cookies
  Secret32 group;   // seals beacons to the group
};

// BLAKE2b-128 of the bytes, keyed.
Mac mac_of(Bytes key, Bytes bytes);

}  // namespace onemap::comms
