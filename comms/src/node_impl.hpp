#pragma once
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "apply_queue.hpp"
#include "comms/node.hpp"
#include "comms/wire.hpp"
#include "comms/wire/payload.hpp"
#include "consensus/talks.hpp"
#include "fetch/fetcher.hpp"
#include "hal/base/splitmix.hpp"
#include "hash_cache.hpp"
#include "held_logs.hpp"
#include "memory/arena.hpp"
#include "memory/log_map.hpp"
#include "notary.hpp"
#include "pacer.hpp"
#include "peer/peer.hpp"
#include "replacements.hpp"
#include "team_table.hpp"
#include "trickle.hpp"

namespace onemap::comms {

RateBounds rate_bounds(const NodeConfig& config);

struct Node::Impl {
  using Peers = Fetcher::Peers;
  Impl(NodeConfig config_, LogStore& store_);

  // node.cpp: the record set
  std::uint32_t held(const LogId& log) const;
  Result<RecordId> append(std::uint8_t lane, std::uint16_t kind, std::vector<std::uint8_t> body,
                          std::uint32_t replaces);
  void stored(const RecordId& id, std::uint8_t hops);  // the store has one record more, that others may hear of
  std::uint32_t told(const LogId& log) const;          // so many that they may
  void settle_own();                                   // tells of own records that have become durable
  void push(const RecordId& id);
  void take_held(const LogId& log, std::uint32_t count);
  void prepare(Peer& peer);
  std::optional<std::uint8_t> hops_of(const RecordId& id) const;
  void refuse(Refusal reason) {
    counters.refuse(reason);
    last_refusal = reason;
  }
  void advance(Instant to);
  Refusal judge(const LogId& log) const;  // whether records of this log may come in; count: yes

  // node_admit.cpp: who may speak
  Peer* admit(const Endpoint& from, const wire::Header& header, std::span<const wire::Frame> frames);
  Peer* admit_greeting(const Endpoint& from, const wire::Header& header, const RobotId& robot);
  Peer* admit_candidate(Peer& peer, const wire::Header& header, std::span<const wire::Frame> frames);
  bool conflicts(const Endpoint& from, const wire::Header& header, const RobotId& robot);
  bool is_still_there(Peer& peer);
  void ask_whether_there(Peer& peer);
  void challenge(Peer& peer, const wire::Header& header, const RobotId& robot);
  void moved(const Endpoint& from, const Endpoint& to);
  void forget(Peers::iterator peer);
  void become(Peer& peer, const RobotId& robot, std::uint64_t incarnation);
  Peer* room_for(const Endpoint& endpoint);
  Peer& place(const Endpoint& endpoint);
  void answer_former_life(const Endpoint& to, const wire::Header& header, const wire::LaterLife& later);
  const Peer* living(const RobotId& robot) const;  // the neighbour, or nobody
  bool names_us(const wire::Header& header) const;

  // node_receive.cpp: what is said
  void receive(const Endpoint& from, std::span<const std::uint8_t> bytes);
  Refusal receive_sealed(const Endpoint& from, const Proof& proof, std::span<const std::uint8_t> frames);
  Refusal begin_session(const Endpoint& from, const Proof& proof);
  Peer* speaker(const Endpoint& from, std::size_t bytes, std::span<const std::uint8_t> frames);
  void hear(Peer& peer, const Session::Arrival& arrival, std::size_t bytes);
  void peer_up(Peer& peer);
  void on_frame(Peer& peer, const Session::Arrival& arrival, const wire::Frame& frame);
  void on_status(const RobotStatus& status);
  void on_beacon(Peer& peer, const Session::Arrival& arrival, const wire::Beacon& beacon);
  void on_have(Peer& peer, const Session::Arrival& arrival, const wire::Have& have);
  void on_have(Peer& peer, const wire::HaveEntry& entry);
  bool room_for_claim(const wire::HaveEntry& entry) const;
  void tell_author(const LogId& log);
  void judge_again();
  void offer_again(const Peer& peer);
  void on_have_request(Peer& peer);
  void on_want(Peer& peer, const wire::Want& want);
  void on_data(Peer& peer, const wire::Data& data);
  void on_mass(Peer& peer, const wire::Mass& mass);
  void on_feedback(Peer& peer, const wire::Feedback& feedback);
  void on_head(Peer& peer, const wire::Head& head);
  void take_fetched();
  Refusal take(Record record, std::optional<SignedHead> by);  // that nobody here said
  void on_pong(Peer& peer, const wire::Pong& pong);
  void on_later_life(const wire::LaterLife& later);

  // node_timer.cpp
  void tick();
  void tick(Peer& peer);
  void peer_down(Peer& peer);
  void changed();  // something that beacons tell
  Duration shared(Duration gap) const;
  void beacon_all();
  void seek();
  void talk();
  bool all_consistent() const;
  void tell_all(Peer& peer);
  Instant next_deadline() const;
  Instant next_deadline(const Peer& peer) const;

  // node_send.cpp
  bool next_outgoing(OutgoingDatagram& datagram);
  bool control_ready(const Peer& peer) const;
  void build_group(OutgoingDatagram& datagram);
  void build_answer(OutgoingDatagram& datagram);
  void build_candidate(Peer& peer, Candidate& candidate, OutgoingDatagram& datagram);
  void build_control(Peer& peer, OutgoingDatagram& datagram);
  bool build_data(OutgoingDatagram& datagram);
  Peer* next_to_serve();
  bool build_push(OutgoingDatagram& datagram);
  void put_mass(wire::Encoder& out, Peer& peer);
  void put_feedback(wire::Encoder& out, Peer& peer);
  std::optional<std::size_t> put_head(wire::Encoder& out, ServeQueue& queue, const Record& record);
  std::optional<std::size_t> put_fragment(wire::Encoder& out, ServeQueue& queue, std::uint8_t lane);
  void put_beacon(wire::Encoder& out);
  void put_status(wire::Encoder& out, const RobotId& except, RobotId& cursor);
  void put_round_trip(wire::Encoder& out, Peer& peer);
  void put_have(wire::Encoder& out, Peer& peer);
  void put_lacking(wire::Encoder& out, Peer& peer);
  void put_wants(wire::Encoder& out, Peer& peer);
  bool serves(const Peer& peer, std::uint8_t lane) const;
  wire::Header header_for(Peer& peer);
  std::size_t sent(OutgoingDatagram& datagram, const Endpoint& to, std::size_t size);
  void sent(OutgoingDatagram& datagram, Peer& peer, std::size_t size, bool data);
  void count_sent(FrameType type) { ++counters.frames_sent[index_of(type)]; }

  NodeConfig config;
  Arena memory;  // before all that lives in it
  LogStore& store;
  Counters counters;
  Instant now{};
  Refusal last_refusal = Refusal::count;
  Peers peers{&memory};
  std::uint32_t counted_to = 1;  // by sessions with peers that are forgotten: nobody's count begins below
  HeldLogs held_logs{memory};
  Notary notary{memory};
  Fetcher fetcher;
  TeamTable team;
  Talks talks;
  std::optional<IdConflict> conflict;
  std::optional<std::uint64_t> outlived;
  std::uint64_t frontier_digest = 0;
  LogMap<std::pmr::vector<std::uint8_t>> hops{memory};
  HashCache hashes{memory};
  ApplyQueue applied{memory};
  Replacements replacements;
  std::pmr::deque<RecordId> undurable{&memory};  // own records that nobody may hear of yet
  std::optional<Instant> sync_at;                // for what others wrote
  std::string sync_error;
  std::pmr::deque<Complaint> complaints{&memory};
  wire::FragmentBuffer fragment_scratch{};
  wire::Decoder decoder;
  bool plan_due = false;
  bool statuses_due = true;  // the beacons of this round carry what is known of others
  Instant next_statuses{};   // not before
  unsigned quiet_rounds = 0;
  Trickle trickle;  // to those who are here
  Trickle seeking;  // to the group, and to configured peers who are silent: short, and in shorter intervals
  SplitMix random;  // jitter, and tokens
  bool group_due = false;
  std::uint32_t group_counter = 1;
  // To those who are no neighbours: what they cannot know. Never more bytes than they sent.
  struct Answer {
    Endpoint to;
    std::uint64_t receiver = 0;
    wire::LaterLife later;
  };
  std::pmr::deque<Answer> answers{&memory};
  std::uint32_t answer_counter = 1;
  // Sending
  Pacer pacer;
  Endpoint control_cursor;
  double airtime = 0.0;  // virtual, of the neighbour that was served last
  std::pmr::vector<RobotStatus> status_scratch{&memory};
  std::pmr::vector<wire::HaveEntry> have_scratch{&memory};
};

}  // namespace onemap::comms
