#pragma once
#include <cstdint>
#include <map>

#include "comms/datagram_port.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"
#include "session/cookies.hpp"

namespace onemap::comms {

// Beacons to the group, sealed with a key that the whole team has (XChaCha20-Poly1305, random nonces). Of each sender
// only what is newer than all before is taken, so a copy says nothing.
class GroupSeal {
 public:
  GroupSeal(const Secret32& key, std::uint64_t incarnation, Memory& memory = heap())
      : key_(key), incarnation_(incarnation), senders_(&memory) {}

  // A plain group datagram of the Node becomes a sealed one, in its place.
  void seal(OutgoingDatagram& datagram, const RandomBytes& random);

  struct Opened {
    RobotId robot;
    std::uint64_t incarnation = 0, counter = 0;
    Bytes frames;  // valid as long as `room` is
  };
  // Refusal::count when it is good. Frames begin with a BEACON: it says whose they are.
  Refusal open(Instant now, Bytes datagram, MutableBytes room, Opened& opened);

 private:
  static constexpr std::size_t kMost = 1024;  // senders that are remembered
  struct Sender {
    std::uint64_t incarnation = 0, counter = 0;
    Instant heard{};
  };
  bool is_news(Instant now, const Opened& opened);
  const Secret32& key_;
  std::uint64_t incarnation_, counter_ = 0;
  std::pmr::map<RobotId, Sender> senders_;
};

}  // namespace onemap::comms
