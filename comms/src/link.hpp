#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "comms/endpoint.hpp"
#include "comms/wire.hpp"
#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "receive_window.hpp"
#include "round_trip.hpp"
#include "serve_queue.hpp"

namespace onemap::comms {

// A fragment that was asked for. Asks of one lane are served in the order in which they were asked.
struct Ask {
  RecordId id;
  std::uint32_t fragment = 0;
  std::uint32_t serial = 0;             // unique within the node, ascending within a lane
  bool done = false;                    // answered, given up or no longer needed
  std::uint8_t overtaken = 0;           // later asks that were answered
  std::optional<Instant> overtaken_at;  // when that became enough to suspect a loss
};

struct AskLane {
  std::deque<Ask> asks;                  // in order of asking; done ones are dropped from the front
  std::size_t outstanding = 0;           // of them, not done
  Instant progress{};                    // last answer in this lane or a lower one, or the first ask after idleness
  std::optional<Instant> suspect_since;  // the earliest overtaken_at
};

// Who greets from the address of a living neighbour under another name or life: first it has to name our incarnation,
// then to repeat a token that was sent to that address.
struct Candidate {
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: nobody
  bool beacon_due = false, ping_due = false;
  std::uint32_t token = 0;  // 0: it has not named us yet
  Instant stays_until{};    // before that, no other takes its place
};

// All that is known about one endpoint: who it is, what it holds, what is asked of it and what it asked for.
struct Link {  // NOLINT(clang-analyzer-optin.performance.Padding): in the order of meaning
  // who
  Endpoint endpoint;
  bool configured = false;  // greeted although it never answered
  bool ever_heard = false;  // by whatever name
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: never heard
  bool proved = false;            // it has named our incarnation, so it hears us at this address
  bool alive = false;             // proved, and heard within the time limit
  Instant last_heard{};
  Candidate candidate;

  // datagrams
  std::uint32_t next_counter = 1;
  ReceiveWindow window, group_window;
  RoundTrip round_trip;
  std::uint64_t bytes_in = 0, bytes_out = 0;

  // what it says
  VersionVector holds;
  std::uint64_t holds_digest = 0;
  std::uint64_t claimed_digest = 0, map_digest = 0;
  std::uint64_t claimed_at = 0;  // unfolded datagram counter of the claim
  std::uint8_t flags = 0;
  std::optional<Instant> request_have_at;  // its digest differs from what we think it holds
  unsigned have_requests = 0;              // in a row, without success
  Instant last_have_request{};
  bool has_refused_logs = false;  // it holds what we do not take: then the digests differ for long

  // what to tell it
  bool beacon_due = false;
  bool have_request_due = false;
  std::optional<std::uint32_t> pong_due;
  bool ping_due = false;
  bool status_echo_due = false;                 // what it said about itself is older than what others say that it said
  std::optional<std::uint64_t> later_life_due;  // somebody offers records of its, of this later life
  Instant later_life_again{};
  std::set<LogId> have_dirty;
  std::optional<Instant> have_at;
  Instant last_have{}, next_full_have{};
  RobotId status_cursor;  // where the next status frame starts
  std::vector<wire::WantEntry> wants;
  std::optional<Instant> want_at;

  // what was asked of it
  std::array<AskLane, kLaneCount> lanes;
  unsigned silences = 0;     // in a row
  bool may_ask_bulk = true;  // the window has opened enough to be filled again
  Instant avoid_until{};
  Instant next_ping{};
  std::uint32_t ping_token = 0;
  std::optional<Instant> ping_sent;

  ServeQueue serve;

  std::size_t outstanding() const;
  void forget_peer();  // another robot or incarnation speaks from here now
};

}  // namespace onemap::comms
