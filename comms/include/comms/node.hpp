#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <memory_resource>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "comms/consensus/scalars.hpp"
#include "comms/counters.hpp"
#include "comms/datagram_port.hpp"
#include "comms/endpoint.hpp"
#include "comms/frontier.hpp"
#include "comms/identity.hpp"
#include "comms/keeping.hpp"
#include "comms/log_store.hpp"
#include "comms/record_head.hpp"
#include "comms/status.hpp"
#include "comms/traffic.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

struct NodeConfig {
  RobotId self;  // a valid name
  // One life of this robot, from 1 to 2^63 - 1; a later start must use a greater one, so it comes from a counter that
  // is kept. outlived() tells when neighbours know a later one.
  std::uint64_t incarnation = 1;
  std::optional<Identity> identity{};           // what own records are signed with; without one nothing can be appended
  std::vector<Endpoint> peers;                  // greeted from the start; others are accepted when they greet us
  std::optional<Endpoint> group;                // multicast group for beacons
  std::uint64_t bytes_per_second = 16'000'000;  // of record bodies at most, over all neighbours
  // Data to one neighbour, IP and UDP headers included: never slower, never faster. Between, the protocol finds the
  // rate that the way carries.
  std::uint64_t link_least_bytes_per_second = 8'000, link_most_bytes_per_second = 125'000'000;
  // What people allow on the link to one neighbour, both ways together; beyond it only control and poses go. 0: no
  // limit.
  std::uint64_t link_budget_bytes_per_second = 0, link_budget_bytes_per_day = 0;
  std::size_t train_datagrams = 8;  // at most this many at once
  Duration beacon_min = std::chrono::milliseconds(250), beacon_max = std::chrono::seconds(6);
  Duration neighbour_timeout = std::chrono::seconds(20);
  // Asked for and not yet arrived, from one neighbour: so much at first, and more on a way that is fast and long.
  std::size_t credit_bytes = 256u << 10, most_credit_bytes = 2u << 20;
  std::size_t reassembly_bytes = 7u << 19;  // incomplete or out of order records
  // One block, taken at the start, in which all that a Node and its Guard remember lives; records that are whole and
  // due go to the store. At once: its pages, too, and not as they are used.
  std::size_t memory_bytes = 25u << 18;
  bool memory_at_once = false;
  // Configured peers always have their place; of the other neighbours of one address there may be a quarter of
  // max_neighbours.
  std::size_t max_neighbours = 32;
  std::size_t max_robots = 1024;                         // that count: see team()
  bool sealed = false;                                   // a Guard stands between this node and the network
  std::size_t max_logs = 4096, max_logs_of_robot = 256;  // a life of a robot has up to kLaneCount logs
  KeepingOf keeping{};                                   // of which kinds bodies may be dropped; empty: of none
};

struct NeighbourStatus {
  RobotId robot;
  std::uint64_t incarnation = 0;
  Endpoint endpoint;
  bool alive = false;  // both directions proved, heard within neighbour_timeout
  Instant last_heard{};
  double loss = 0.0;      // estimate of datagrams lost on the way from there to here, 0..1
  Duration round_trip{};  // smoothed; 0 when not measured yet
  std::uint64_t bytes_in = 0, bytes_out = 0;
  double rate = 0.0;      // bytes a second at which data may go there now
  Duration queue{};       // that data wait on the way there; 0 when not measured
  double loss_there = 0;  // of datagrams on the way there, as it says itself, 0..1
  // Of record bodies, in whole fragments: asked of it and not come yet; asked by it and not sent yet.
  std::uint64_t asked_bytes = 0, queued_bytes = 0;
  std::uint64_t frontier_digest = 0, map_digest = 0;  // as it last said itself
  std::uint8_t flags = 0;
  Traffic traffic;                // bytes_in and bytes_out, by kind
  bool within_budget = true;      // of the link: more than control and poses may go
  std::uint64_t bytes_today = 0;  // against the day's budget, IP and UDP headers included
  // Expected transmissions until a datagram and its answer have come through (De Couto and others, 2003).
  double etx() const { return 1.0 / std::max((1.0 - loss) * (1.0 - loss_there), 1e-3); }
};

// What is known of a robot that has records here or is a neighbour.
struct Presence {
  std::uint64_t incarnation = 0;
  Instant last_sign{};  // of life: a datagram, a newer status by hearsay, or a new record of its own
  bool neighbour = false;
  std::uint8_t flags = 0;
};

// Of NodeConfig::memory_bytes, in bytes.
struct MemoryView {
  std::size_t capacity = 0, used = 0, most_used = 0;
  std::uint64_t spilled = 0;  // pieces that the heap gave because none fitted
};

// Somebody else uses this robot's id.
struct IdConflict {
  Endpoint where;
  std::uint64_t incarnation = 0;
  Instant when{};
};

// Somebody served what is not its author's, or not all of it: a lie, or an author that signs two histories (forked).
struct Complaint {
  Refusal reason = Refusal::count;  // bad_signature, second_key, live_head or forked
  RecordId record;
  RobotId from;  // the neighbour that served it
  Endpoint endpoint;
};

// One robot's side of the protocol (comms/PROTOCOL.md), as a pure function of bytes and `now`: no clock, socket or
// thread. Call it from one thread, like this, with a `now` that never goes back:
//
//   while datagrams wait:                 node.on_datagram(now, from, bytes)
//   when now >= node.next_deadline():     node.on_timer(now)
//   after any of these and after append:  while (node.next_outgoing(d)) port.send(d);
//                                         while (node.next_applied(r)) apply(r);
//   sleep until next_deadline() or a datagram
//
// Every record that any robot of the connected team wrote reaches every robot, over several hops, in spite of loss,
// duplication and reordering; equal frontiers mean equal record sets.
class Node {
 public:
  // The store must outlive the node. Records that it already holds are given out by next_applied first.
  Node(NodeConfig config, LogStore& store);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  void on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes);
  void on_timer(Instant now);
  Instant next_deadline() const;  // call on_timer then, or earlier

  // For a Guard, in place of on_datagram: it has proved who speaks, and takes each datagram once. Refusal::count:
  // taken; else why not, counted.
  struct Proof {
    RobotId robot;
    std::uint64_t incarnation = 0;
    std::uint64_t counter = 0;  // later datagrams of one sender have greater ones
    std::size_t bytes = 0;      // of the datagram
    double loss = 0.0;          // of what came from there, 0..1
    bool group = false;         // anybody of the team may have sealed it
  };
  Refusal on_session(Instant now, const Endpoint& from, const Proof& proof);  // one begins: a proved neighbour
  Refusal on_sealed(Instant now, const Endpoint& from, const Proof& proof, std::span<const std::uint8_t> frames);
  void on_moved(Instant now, const Endpoint& from, const Endpoint& to);  // a neighbour has another address now

  // Writes the next record of the own log of this lane. The error says why it cannot: the body is larger than
  // kMaxRecordBytes, or the lane is unknown, or the store has no room (in its words); counted.
  // replaces: a record of this log and kind that is needless from now on (Keeping::until_it_may_go).
  Result<RecordId> append(Instant now, std::uint8_t lane, std::uint16_t kind, std::vector<std::uint8_t> body,
                          std::uint32_t replaces = kNoSequence);
  // Nobody here reads this record again: its body goes, if its author has said that it is needless (a record of its own
  // kind did; who asks has seen that). False: it stays.
  bool let_go(const RecordId& id);
  // A record that came on another way than over the network: the same is asked of it, and that it is the next of its
  // log here. by: if its body is gone, the head of the later record that made it needless. Count: it is here now; else
  // why not, counted. A fork does not end its log here: who brought it is no neighbour that would bring it again.
  Refusal take(Instant now, Record record, std::optional<SignedHead> by);
  // What beacons say about this robot; sent at once when it changed (at most ten times a second, and
  // seldomer with more than four neighbours).
  void set_local_status(Instant now, std::uint64_t map_digest, std::uint8_t flags);

  // What this robot brings to the team's talks, as often as it is known anew.
  void bring(Instant now, Scalar which, double own);
  ScalarsView scalars() const;

  bool next_outgoing(OutgoingDatagram& datagram);            // false: nothing to send at the last `now`
  bool next_applied(std::shared_ptr<const Record>& record);  // each stored record once, own and others', in log order

  // About records that were refused; the latest 64.
  std::optional<Complaint> next_complaint();
  // Somebody vouches that this is the key of this robot, as a session with it does. False: another one counts here.
  bool pin(const RobotId& robot, const PublicKey& key);
  std::optional<PublicKey> key_of(const RobotId& robot) const;  // that its records are signed with

  const VersionVector& frontier() const;
  std::uint64_t frontier_digest() const;  // digest(frontier())
  std::vector<NeighbourStatus> neighbours() const;

  // The robots that count, with their newest word: this one, those of whom records are here, and living neighbours. Who
  // is only talked about does not count. A robot that was not heard of since its records came has a status of zeros.
  const std::pmr::map<RobotId, RobotStatus>& team() const;
  std::map<RobotId, Presence> presence(Instant now) const;  // the same robots
  // All robots that count but those in `without` carry these flags, this robot's map digest and its frontier digest.
  bool team_agrees(std::uint8_t flags, const std::set<RobotId>& without) const;

  bool is_configured(const Endpoint& at) const;     // one of NodeConfig::peers
  std::vector<Endpoint> peers_never_heard() const;  // configured ones
  std::optional<IdConflict> id_conflict() const;    // the latest
  // Neighbours say that they hold records of a later life of this robot than the present one: begin a new life after
  // that number, with a new Node, and write what is worth it again. Any neighbour can say so, so bound how often it is
  // believed. Never 2^63 or more.
  std::optional<std::uint64_t> outlived() const;

  // How many records of this log a neighbour says that it holds, without a gap.
  std::uint32_t held_by(const RobotId& neighbour, const LogId& log) const;
  // All living neighbours have confirmed to hold all own records of lanes 0 to up_to_lane.
  bool delivered(std::uint8_t up_to_lane) const;
  std::size_t records_missing() const;   // that living neighbours say they hold and this robot does not, yet
  std::set<RobotId> incomplete() const;  // other robots whose records these are
  std::string store_full() const;        // why records of others that arrived cannot be kept; empty: they can
  // Every own record is durable, as far as the store can promise that, and so told and for next_applied to give out.
  bool own_settled() const;
  std::optional<std::uint8_t> hops(const RecordId& id) const;  // links that this record came over; 0: own
  const Counters& counters() const;
  MemoryView memory_view() const;
  std::pmr::memory_resource& memory();  // for its Guard

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::comms
