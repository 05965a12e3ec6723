#pragma once
#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "comms/endpoint.hpp"
#include "comms/wire.hpp"
#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "serve_queue.hpp"

namespace onemap::comms {

// Which datagram counters of a sender were seen, and how many were lost.
class ReceiveWindow {
 public:
  enum class Verdict { fresh, duplicate, too_old };
  Verdict accept(std::uint32_t counter);
  double loss() const { return loss_; }

 private:
  static constexpr std::uint32_t kWindow = 2048, kBlock = 64;
  void count_block();
  std::bitset<kWindow> seen_;
  std::uint32_t highest_ = 0, block_start_ = 0, received_in_block_ = 0;
  double loss_ = 0.0;
  bool measured_ = false;
};

// Smoothed round trip and the silence after which an answer is given up (RFC 6298, with a floor fit for one hop).
class RoundTrip {
 public:
  static constexpr unsigned kPatientSilences = 4;  // silences that do not lengthen the wait
  void sample(Duration rtt);
  Duration smoothed() const { return srtt_; }  // 0: not measured
  Duration give_up_after(unsigned silences) const;
  Duration reorder_window() const;  // how long an overtaken datagram may still be on its way
  void was_hasty();                 // what had been given up came after all

 private:
  Duration srtt_{0}, var_{0}, hasty_{0};
};

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

// All that is known about one endpoint: who it is, what it holds, what is asked of it and what it asked for.
struct Link {  // NOLINT(clang-analyzer-optin.performance.Padding): in the order of meaning
  // who
  Endpoint endpoint;
  bool configured = false;  // greeted although it never answered
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: never heard
  bool alive = false;             // it knows our incarnation, and was heard within the time limit
  Instant last_heard{};

  // datagrams
  std::uint32_t next_counter = 1;
  ReceiveWindow window, group_window;
  RoundTrip round_trip;
  std::uint64_t bytes_in = 0, bytes_out = 0;

  // what it says
  VersionVector holds;
  std::uint64_t holds_digest = 0;
  std::uint64_t claimed_digest = 0, map_digest = 0;
  std::uint32_t claimed_at = 0;  // datagram counter of the claim
  std::uint8_t flags = 0;
  std::optional<Instant> request_have_at;  // its digest differs from what we think it holds
  unsigned have_requests = 0;              // in a row, without success

  // what to tell it
  bool beacon_due = false;
  bool have_request_due = false;
  std::optional<std::uint32_t> pong_due;
  bool ping_due = false;
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
