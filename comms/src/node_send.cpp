// What is sent, and in which order: answers, the group, control, bodies.
#include <algorithm>

#include "node_impl.hpp"
#include "session/sealed_wire.hpp"
#include "traffic_count.hpp"

namespace onemap::comms {

namespace {
// The first entry after `cursor`, going round.
template <class Map, class Key>
auto after(Map& map, const Key& cursor) {
  auto at = map.upper_bound(cursor);
  return at == map.end() ? map.begin() : at;
}
}  // namespace

bool Node::Impl::next_outgoing(OutgoingDatagram& datagram) {
  if (plan_due) fetcher.plan(now, peers);
  plan_due = false;
  if (!answers.empty()) return build_answer(datagram), true;
  if (group_due) return build_group(datagram), true;
  if (build_push(datagram)) return true;
  auto it = after(peers, control_cursor);
  for (std::size_t i = 0; i < peers.size(); ++i) {
    if (control_ready(it->second)) {
      control_cursor = it->first;
      if (Candidate* const candidate = it->second.candidates.next())
        build_candidate(it->second, *candidate, datagram);
      else
        build_control(it->second, datagram);
      return true;
    }
    if (++it == peers.end()) it = peers.begin();
  }
  return build_data(datagram);
}

bool Node::Impl::control_ready(const Peer& peer) const {
  if (peer.outbox.beacon_due || peer.candidates.due()) return true;
  return peer.who.alive && (peer.pings.answer_due || peer.pings.due || peer.outbox.due(now) || peer.arrivals.due(now));
}

wire::Header Node::Impl::header_for(Peer& peer) {
  return peer.session.next_header(config.incarnation, peer.who.incarnation);
}

// How many bytes will be on the wire.
std::size_t Node::Impl::sent(OutgoingDatagram& datagram, const Endpoint& to, std::size_t size) {
  datagram.to = to;
  datagram.size = size;
  const bool group = config.group == to;
  if (config.sealed) size += (group ? sealed::kGroupOverheadBytes : sealed::kOverheadBytes) - wire::kHeaderBytes;
  ++counters.datagrams_sent;
  counters.bytes_sent += size;
  pacer.sent(now, size);
  return size;
}

void Node::Impl::sent(OutgoingDatagram& datagram, Peer& peer, std::size_t size, bool data) {
  const std::size_t on_wire = sent(datagram, peer.endpoint, size);
  peer.bytes_out += on_wire;
  count_traffic(peer.traffic.out, std::span(datagram.buffer).first(size).subspan(wire::kHeaderBytes), on_wire);
  peer.budget.spent(now, on_wire + RateController::kIpUdpBytes);
  peer.rate.sent(now, peer.session.last_counter(), on_wire, data);
  if (peer.serve.empty() || !peer.budget.allows(now)) peer.rate.held_up();  // until the next one
}

void Node::Impl::put_beacon(wire::Encoder& out) {
  const RobotStatus& own = team.say_own();
  out.beacon({config.self, own.frontier_digest, own.map_digest, own.counter, own.flags});
  count_sent(FrameType::beacon);
}

// As many robots as fit, starting where the last frame ended.
void Node::Impl::put_status(wire::Encoder& out, const RobotId& except, RobotId& cursor) {
  status_scratch.clear();
  auto it = after(team.robots(), cursor);
  for (std::size_t i = 0; i < team.robots().size(); ++i) {
    if (it->first != config.self && it->first != except && it->second.counter != 0)
      status_scratch.push_back(it->second);
    if (++it == team.robots().end()) it = team.robots().begin();
  }
  const std::size_t n = out.status(status_scratch);
  if (n == 0) return;
  cursor = status_scratch[n - 1].robot;
  count_sent(FrameType::status);
}

void Node::Impl::put_wants(wire::Encoder& out, Peer& peer) {
  const std::size_t n = out.want(static_cast<std::uint32_t>(fetcher.credit_to_announce(peer)), peer.outbox.wants());
  if (n == 0) return;
  peer.outbox.wanted(now, n);
  count_sent(FrameType::want);
}

void Node::Impl::build_group(OutgoingDatagram& datagram) {
  group_due = false;
  wire::Encoder out(datagram.buffer, {wire::DatagramType::group, config.incarnation, 0, group_counter});
  group_counter = wire::next_counter(group_counter);
  put_beacon(out);  // what is told of others goes to neighbours, who are greeted by name
  sent(datagram, *config.group, out.size());
}

// 51 bytes for a greeting of 64.
void Node::Impl::build_answer(OutgoingDatagram& datagram) {
  const Answer answer = answers.front();
  answers.pop_front();
  wire::Encoder out(datagram.buffer,
                    {wire::DatagramType::unicast, config.incarnation, answer.receiver, answer_counter});
  answer_counter = wire::next_counter(answer_counter);
  out.later_life(answer.later);
  count_sent(FrameType::later_life);
  sent(datagram, answer.to, out.size());
}

// One frame, not more than what came from there.
void Node::Impl::build_candidate(Peer& peer, Candidate& candidate, OutgoingDatagram& datagram) {
  wire::Encoder out(datagram.buffer, peer.session.next_header(config.incarnation, candidate.incarnation));
  if (std::exchange(candidate.ping_due, false)) {
    out.ping(candidate.token);
    count_sent(FrameType::ping);
  } else {
    put_beacon(out);
  }
  candidate.beacon_due = false;
  sent(datagram, peer, out.size(), false);
}

void Node::Impl::build_control(Peer& peer, OutgoingDatagram& datagram) {
  wire::Encoder out(datagram.buffer, header_for(peer));
  const bool beacon = std::exchange(peer.outbox.beacon_due, false);
  if (beacon) put_beacon(out);
  if (peer.who.alive) {  // a stranger gets no more than it sent
    put_round_trip(out, peer);
    if (peer.arrivals.worth_saying(now)) put_feedback(out, peer);
    Outbox& box = peer.outbox;
    if (box.later_life_due && out.later_life({peer.who.robot, *box.later_life_due})) {
      box.later_life_due.reset();
      count_sent(FrameType::later_life);
    }
    if (box.have_request_due && out.have_request()) {
      box.have_request_due = false;
      count_sent(FrameType::have_request);
    }
    if (beacon || box.mass_due) put_mass(out, peer);
    if (!box.wants().empty()) put_wants(out, peer);
    // A beacon's digest must not run ahead of what the neighbour was told.
    if (!box.changed().empty() && (beacon || box.have_due(now)))
      put_have(out, peer);
    else if (beacon)
      put_lacking(out, peer);
    if (beacon && (statuses_due || box.status_echo_due))
      put_status(out, std::exchange(box.status_echo_due, false) ? RobotId{} : peer.who.robot, box.status_cursor);
  }
  sent(datagram, peer, out.size(), false);
}

void Node::Impl::put_round_trip(wire::Encoder& out, Peer& peer) {
  Pings& pings = peer.pings;
  if (pings.answer_due && out.pong(*std::exchange(pings.answer_due, std::nullopt))) count_sent(FrameType::pong);
  if (!pings.due || !out.ping(pings.next_token())) return;
  pings.sent(now);
  count_sent(FrameType::ping);
}

void Node::Impl::put_mass(wire::Encoder& out, Peer& peer) {
  wire::Mass mass;
  const double came = 1.0 - peer.session.loss();
  mass.heard = static_cast<std::uint16_t>(std::clamp(came * 65535.0, 1.0, 65535.0));
  mass.neighbours = static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(
      std::count_if(peers.begin(), peers.end(), [](const auto& entry) { return entry.second.who.alive; }), 255));
  talks.tell(now, peer.who.robot, mass);
  mass.has_amounts = mass.round != 0 && peer.outbox.amounts_left > 0;
  if (!out.mass(mass)) return;
  peer.outbox.mass_due = false;
  if (mass.has_amounts) --peer.outbox.amounts_left;
  count_sent(FrameType::mass);
}

void Node::Impl::put_feedback(wire::Encoder& out, Peer& peer) {
  if (out.room() < wire::kFrameHeadBytes + wire::kFeedbackBytes) return;
  out.feedback(peer.arrivals.report(now));
  count_sent(FrameType::feedback);
}

// Own control and pose records, unasked: they wait for no turn and no rate, and use up both.
bool Node::Impl::build_push(OutgoingDatagram& datagram) {
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive || !peer.push.due(now)) continue;
    wire::Encoder out(datagram.buffer, header_for(peer));
    while (peer.push.due(now) && out.data(peer.push.front())) {
      counters.body_bytes_sent += peer.push.front().bytes.size();
      ++counters.records_pushed;
      count_sent(FrameType::data);
      peer.push.sent(now);
    }
    sent(datagram, peer, out.size(), false);
    return true;
  }
  return false;
}

// Control and poses of anybody first; then whoever had the least time on air.
Peer* Node::Impl::next_to_serve() {
  Peer* best = nullptr;
  bool best_urgent = false;
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive || peer.serve.empty() || !peer.rate.open(now)) continue;
    const bool urgent = !peer.serve.empty(0) || !peer.serve.empty(1);
    if (!urgent && !peer.budget.allows(now)) continue;
    const bool sooner =
        best == nullptr || (urgent != best_urgent ? urgent : peer.turn.start(airtime) < best->turn.start(airtime));
    if (!sooner) continue;
    best = &peer;
    best_urgent = urgent;
  }
  return best;
}

// Beyond the link's budget only control and poses go.
bool Node::Impl::serves(const Peer& peer, std::uint8_t lane) const {
  return !peer.serve.empty(lane) && (lane <= wire::kLastPushedLane || peer.budget.allows(now));
}

bool Node::Impl::build_data(OutgoingDatagram& datagram) {
  if (!pacer.open(now)) {
    for (auto& [endpoint, peer] : peers)
      if (!peer.serve.empty()) peer.rate.held_up();
    return false;
  }
  Peer* peer = next_to_serve();
  if (peer == nullptr) return false;
  const auto waits = [&](std::uint8_t lane) { return serves(*peer, lane); };
  wire::Encoder out(datagram.buffer, header_for(*peer));
  for (std::uint8_t lane = peer->lanes.next(waits); lane < kLaneCount; lane = peer->lanes.next(waits)) {
    const auto bytes = put_fragment(out, peer->serve, lane);
    if (!bytes) break;
    peer->lanes.sent(lane, *bytes, waits);
  }
  airtime = peer->turn.sent(airtime, out.size(), peer->rate.bytes_per_second());
  sent(datagram, *peer, out.size(), true);
  return true;
}

// With what took its place; without that, nobody would take it.
std::optional<std::size_t> Node::Impl::put_head(wire::Encoder& out, ServeQueue& queue, const Record& record) {
  const std::uint8_t lane = record.id.log.lane;
  const auto later = replacements.instead_of(record.id);
  const auto by = later ? store.find(*later) : nullptr;
  if (by == nullptr) return queue.pop_record(lane), refuse(Refusal::unreadable), 0;
  const std::uint8_t way = queue.front(lane).hops;
  if (!out.head({head_of(record), way, record.seal.signature, {head_of(*by), by->seal.signature}})) return std::nullopt;
  count_sent(FrameType::head);
  return queue.pop_record(lane), wire::kHeadFrameBytes;
}

// What is next of a lane: how many bytes of it; nothing when it does not fit. The body may be gone since it was asked
// for.
std::optional<std::size_t> Node::Impl::put_fragment(wire::Encoder& out, ServeQueue& queue, std::uint8_t lane) {
  const ServeQueue::Next next = queue.front(lane);
  const auto record = store.find(next.id);
  if (record == nullptr) return queue.pop_record(lane), refuse(Refusal::unreadable), 0;
  if (record->dropped) return put_head(out, queue, *record);
  wire::Data data;
  data.id = next.id;
  data.kind = record->kind;
  data.hops = next.hops;
  data.total_bytes = wire::payload_bytes(*record);
  data.body_hash = hashes.of(*record);
  data.fragment = static_cast<std::uint16_t>(next.fragment);
  data.bytes = wire::fragment_of(*record, next.fragment, fragment_scratch);
  if (!out.data(data)) return std::nullopt;
  counters.body_bytes_sent += data.bytes.size();
  count_sent(FrameType::data);
  return queue.pop(lane), data.bytes.size();
}

}  // namespace onemap::comms
