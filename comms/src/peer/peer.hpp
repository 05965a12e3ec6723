#pragma once
#include <cstdint>

#include "comms/endpoint.hpp"
#include "fetch/ask_ledger.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"
#include "peer/candidate.hpp"
#include "peer/outbox.hpp"
#include "peer/peer_frontier.hpp"
#include "peer/pings.hpp"
#include "peer/round_trip.hpp"
#include "peer/serve_queue.hpp"
#include "session/session.hpp"

namespace onemap::comms {

// Who speaks from an endpoint, and whether it is there.
struct Who {
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: nobody was heard yet
  bool proved = false;            // it has named our life, so it hears us at this address
  bool alive = false;             // proved, and heard within the time limit
  Instant last_heard{};
};

// What it says about itself in beacons, the digest of its frontier aside.
struct OwnWord {
  std::uint64_t map_digest = 0;
  std::uint8_t flags = 0;
};

// All that is known about one endpoint, each part with its own rules.
struct Peer {
  Endpoint endpoint;
  bool configured = false;  // greeted although it never answered, and keeps its place
  bool ever_heard = false;  // by whatever name
  Who who;
  Candidate candidate;  // another who would speak from here
  Session session;
  RoundTrip round_trip;
  Pings pings;
  OwnWord word;
  PeerFrontier frontier;  // what it holds
  Outbox outbox;          // what it is told
  AskLedger asks;         // what was asked of it
  ServeQueue serve;       // what it asked for
  std::uint64_t bytes_in = 0, bytes_out = 0;

  // Another robot or life speaks from here from now on: nothing that was known holds, but we go on counting.
  void become(const RobotId& robot, std::uint64_t incarnation);
};

}  // namespace onemap::comms
