#pragma once
#include <cstdint>
#include <optional>

#include "comms/endpoint.hpp"
#include "comms/traffic.hpp"
#include "fetch/ask_ledger.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"
#include "peer/candidate.hpp"
#include "peer/outbox.hpp"
#include "peer/peer_frontier.hpp"
#include "peer/pings.hpp"
#include "peer/push_queue.hpp"
#include "peer/round_trip.hpp"
#include "peer/serve_queue.hpp"
#include "rate/airtime.hpp"
#include "rate/arrivals.hpp"
#include "rate/lane_order.hpp"
#include "rate/link_budget.hpp"
#include "rate/rate_controller.hpp"
#include "session/session.hpp"

namespace onemap::comms {

// Who speaks from an endpoint, and whether it is there.
struct Speaker {
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: nobody was heard yet
  bool proved = false;            // it has named our life, so it hears us at this address
  bool alive = false;             // proved, and heard within the time limit
  Instant last_heard{};
  // Others tell of a later life of it: until then it is asked whether it is still there; after silence it is doubtful.
  std::optional<Instant> asked_until{};
  bool doubtful = false;
};

// What it says about itself in beacons, the digest of its frontier aside.
struct OwnWord {
  std::uint64_t map_digest = 0;
  std::uint8_t flags = 0;
  std::optional<double> loss_there{};  // of our datagrams, 0..1
  std::size_t neighbours = 1;          // that it has itself
};

// All that is known about one endpoint, each part with its own rules.
struct Peer {
  explicit Peer(Memory& memory)
      : frontier(memory), outbox(memory), asks(memory), serve(memory), push(memory), rate({}, memory) {}
  Endpoint endpoint;
  bool configured = false;  // greeted although it never answered, and keeps its place
  bool ever_heard = false;  // by whatever name
  Speaker who;
  Candidates candidates;  // others who would speak from here
  Session session;
  RoundTrip round_trip;
  Pings pings;
  OwnWord word;
  PeerFrontier frontier;  // what it holds
  Outbox outbox;          // what it is told
  AskLedger asks;         // what was asked of it
  ServeQueue serve;       // what it asked for
  PushQueue push;         // what it gets unasked
  RateController rate;    // how fast data may go there
  LaneOrder lanes;        // which of its lanes is next
  AirtimeTurn turn;
  Arrivals arrivals;  // what came from there, for its rate
  LinkBudget budget;
  Traffic traffic;
  std::uint64_t bytes_in = 0, bytes_out = 0;

  // Another robot or life speaks from here from now on: nothing that was known holds, but we go on counting.
  void become(const RobotId& robot, std::uint64_t incarnation, Memory& memory);
};

}  // namespace onemap::comms
