// What a neighbour says.
#include <algorithm>

#include "node_impl.hpp"
#include "traffic_count.hpp"

namespace onemap::comms {

namespace {
constexpr std::size_t kMaxServeBytes = 2u << 20;  // whatever credit a neighbour gives itself

}  // namespace

void Node::Impl::receive(const Endpoint& from, std::span<const std::uint8_t> bytes) {
  ++counters.datagrams_received;
  counters.bytes_received += bytes.size();
  const Refusal verdict = decoder.decode(bytes);
  if (verdict != Refusal::count) return refuse(verdict);
  const wire::Header& header = decoder.header();
  Peer* const peer = speaker(from, bytes.size(), bytes.subspan(wire::kHeaderBytes));
  if (peer == nullptr) return;
  const bool proved = names_us(header);
  if (proved || !peer->who.alive) peer->who.last_heard = now;
  const bool group = header.type == wire::DatagramType::group;
  if (!proved && !(peer->who.alive && group)) {  // it is worth no more than a short greeting
    ++counters.frames_received[index_of(FrameType::beacon)];
    peer->outbox.beacon_due = true;
    return;
  }
  Session::Arrival arrival;
  if (const Refusal late = peer->session.accept(header, arrival); late != Refusal::count) return refuse(late);
  hear(*peer, arrival, bytes.size());
}

// Of the datagram that the decoder holds.
Peer* Node::Impl::speaker(const Endpoint& from, std::size_t bytes, std::span<const std::uint8_t> frames) {
  if (const auto known = peers.find(from); known != peers.end()) known->second.ever_heard = true;
  Peer* const peer = admit(from, decoder.header(), decoder.frames());
  if (peer == nullptr) return nullptr;
  peer->bytes_in += bytes;
  count_traffic(peer->traffic.in, frames, bytes);
  peer->budget.spent(now, bytes + RateController::kIpUdpBytes);
  return peer;
}

void Node::Impl::hear(Peer& peer, const Session::Arrival& arrival, std::size_t bytes) {
  peer.asks.is_there();
  peer.who.asked_until.reset();
  peer.who.doubtful = false;
  if (!peer.who.alive) peer_up(peer);
  if (arrival.unicast) {
    const auto data = std::ranges::count_if(
        decoder.frames(), [](const wire::Frame& frame) { return std::holds_alternative<wire::Data>(frame); });
    peer.arrivals.came(now, arrival.at, static_cast<std::uint32_t>(data), bytes);
  }
  for (const wire::Frame& frame : decoder.frames()) {
    ++counters.frames_received[index_of(wire::type_of(frame))];
    on_frame(peer, arrival, frame);
  }
}

void Node::Impl::peer_up(Peer& peer) {
  peer.who.alive = peer.who.proved = true;
  peer.outbox.beacon_due = true;
  peer.pings.due = true;
  peer.frontier.be_patient_again();
  talks.team_changed(now);
  team.met(peer.who.robot, peer.who.incarnation, now);
  // The author is here itself: what others told of later lives of it is not asked for any longer. When they tell it
  // again it is refused, and the author hears of that.
  for (auto& [endpoint, other] : peers) other.frontier.doubt(peer.who.robot, peer.who.incarnation);
  fetcher.abandon(
      [&](const LogId& log) { return log.robot == peer.who.robot && log.incarnation > peer.who.incarnation; });
  // And what they told of a life that it has begun now was refused until now.
  judge_again();
  tell_all(peer);
  offer_again(peer);
  changed();
  plan_due = true;
}

void Node::Impl::on_frame(Peer& peer, const Session::Arrival& arrival, const wire::Frame& frame) {
  struct Visitor {
    Impl& node;
    Peer& peer;
    const Session::Arrival& arrival;
    void operator()(const wire::Beacon& f) const { node.on_beacon(peer, arrival, f); }
    void operator()(const wire::Status& f) const {
      for (const RobotStatus& status : f.robots) node.on_status(status);
    }
    void operator()(const wire::Have& f) const { node.on_have(peer, arrival, f); }
    void operator()(const wire::HaveRequest&) const { node.on_have_request(peer); }
    void operator()(const wire::Want& f) const { node.on_want(peer, f); }
    void operator()(const wire::Data& f) const { node.on_data(peer, f); }
    void operator()(const wire::Head& f) const { node.on_head(peer, f); }
    void operator()(const wire::Ping& f) const { peer.pings.answer_due = f.token; }
    void operator()(const wire::Pong& f) const { node.on_pong(peer, f); }
    void operator()(const wire::Mass& f) const { node.on_mass(peer, f); }
    void operator()(const wire::Feedback& f) const { node.on_feedback(peer, f); }
    void operator()(const wire::LaterLife& f) const { node.on_later_life(f); }
  };
  std::visit(Visitor{*this, peer, arrival}, frame);
}

void Node::Impl::on_status(const RobotStatus& status) {
  switch (team.merge(status, now)) {
    case TeamTable::Merge::newer:
    case TeamTable::Merge::about_self:
      changed();
      break;
    case TeamTable::Merge::known:
    case TeamTable::Merge::older:
      break;
    case TeamTable::Merge::unknown:
      refuse(Refusal::status_unknown);
      break;
    case TeamTable::Merge::later_self:
      refuse(Refusal::later_life);
      break;
  }
}

void Node::Impl::on_beacon(Peer& peer, const Session::Arrival& arrival, const wire::Beacon& beacon) {
  peer.word.map_digest = beacon.map_digest;
  peer.word.flags = beacon.flags;
  if (arrival.unicast) peer.frontier.claim(now, arrival.at, beacon.frontier_digest, peer.round_trip.smoothed());
  const auto merged = team.merge({beacon.robot, peer.who.incarnation, beacon.status_counter, beacon.frontier_digest,
                                  beacon.map_digest, beacon.flags},
                                 now);
  if (merged == TeamTable::Merge::newer) changed();
  // Late, or somebody put words into its mouth: it shall hear them, and speak up.
  if (merged == TeamTable::Merge::older) peer.outbox.status_echo_due = true;
}

void Node::Impl::on_have(Peer& peer, const Session::Arrival& arrival, const wire::Have& have) {
  for (const wire::HaveEntry& entry : have.entries) on_have(peer, entry);
  peer.frontier.claim(now, arrival.at, have.frontier_digest, peer.round_trip.smoothed());
}

// What neighbours say that they hold, all of them together, must not take the room of what they send. When that is
// much, what another has already said is not kept once more: but whoever alone has something is believed up to twice
// as much.
bool Node::Impl::room_for_claim(const wire::HaveEntry& entry) const {
  constexpr std::size_t kMany = 16'384;  // some 60 bytes each
  std::size_t claims = 0;
  for (const auto& [endpoint, peer] : peers) claims += peer.frontier.logs().size();
  if (claims < kMany) return true;
  return claims < 2 * kMany && entry.count > std::max(held(entry.log), fetcher.offer(entry.log, peers));
}

void Node::Impl::on_have(Peer& peer, const wire::HaveEntry& entry) {
  const std::uint32_t here = held(entry.log);
  const bool own = entry.log.robot == config.self && entry.log.incarnation == config.incarnation;
  Refusal verdict = judge(entry.log);
  if (own && entry.count > here) verdict = Refusal::own_log_ahead;
  const bool another = peer.frontier.count(entry.log) == 0;
  if (another && (peer.frontier.logs().size() >= config.max_logs || !room_for_claim(entry)))
    verdict = Refusal::logs_full;
  if (verdict == Refusal::contradicts_author) tell_author(entry.log);
  if (verdict != Refusal::count) {
    peer.frontier.refused_some();
    return refuse(verdict);
  }
  if (!peer.frontier.raise(entry.log, entry.count) || entry.count <= here) return;
  fetcher.offered(entry.log);
  plan_due = true;
}

// Somebody believes in a later life of a neighbour of ours than the one in which it lives. It shall hear of that: when
// it goes on after that number, all believe it again. Or it went away and lives on elsewhere: then it does not answer.
void Node::Impl::tell_author(const LogId& log) {
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive || peer.who.robot != log.robot) continue;
    peer.outbox.tell_later_life(now, log.incarnation);
    ask_whether_there(peer);
  }
}

// Whether an author lives here has changed, and with it what is believed of what others tell.
void Node::Impl::judge_again() {
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive) continue;
    peer.frontier.judge_again(now);
    offer_again(peer);  // what was given up, and it will not say again
  }
}

void Node::Impl::offer_again(const Peer& peer) {
  for (const auto& [log, count] : peer.frontier.logs())
    if (count > held(log) && judge(log) == Refusal::count) fetcher.offered(log);
  plan_due = true;
}

void Node::Impl::on_have_request(Peer& peer) {
  if (peer.outbox.may_tell_all(now)) tell_all(peer);
}

void Node::Impl::on_want(Peer& peer, const wire::Want& want) {
  const std::size_t credit = std::min<std::size_t>(want.credit_bytes, kMaxServeBytes);
  for (const wire::WantEntry& entry : want.entries) {
    const auto record = entry.id.seq < told(entry.id.log) ? store.find(entry.id) : nullptr;
    if (record == nullptr) {
      refuse(Refusal::want_unknown);
      continue;
    }
    const auto count = wire::fragments_of(wire::payload_bytes(*record));
    std::uint32_t end = std::min<std::uint32_t>(count, std::uint32_t{entry.first} + entry.count);
    if (record->dropped) end = std::uint32_t{entry.first} + 1;  // its head, whatever part was asked for
    if (entry.first >= end) continue;
    const auto way = hops_of(entry.id).value_or(0);
    if (peer.serve.push(entry.id, way, entry.first, end, credit) == ServeQueue::Answer::over_credit)
      refuse(Refusal::want_over_credit);
  }
}

void Node::Impl::on_data(Peer& peer, const wire::Data& data) {
  fetcher.on_data(now, peer, data);
  take_fetched();
}

void Node::Impl::on_head(Peer& peer, const wire::Head& head) {
  fetcher.on_head(now, peer, head);
  take_fetched();
}

void Node::Impl::take_fetched() {
  constexpr std::size_t kMostComplaints = 64;
  constexpr auto kSyncOthers = std::chrono::seconds(1);  // they can be had again
  for (const Fetcher::Stored& record : fetcher.take_stored()) {
    stored(record.id, record.hops);
    if (!sync_at) sync_at = now + kSyncOthers;
  }
  for (const Fetcher::Spoilt& spoilt : fetcher.take_spoilt()) {
    const auto from = peers.find(spoilt.from);
    if (from != peers.end() && spoilt.reason != Refusal::forked) from->second.asks.avoid(now);
    if (complaints.size() == kMostComplaints) complaints.pop_front();
    const RobotId robot = from == peers.end() ? RobotId{} : from->second.who.robot;
    complaints.push_back({spoilt.reason, spoilt.id, robot, spoilt.from});
  }
  plan_due = true;
}

Refusal Node::Impl::take(Record record, std::optional<SignedHead> by) {
  const LogId log = record.id.log;
  Refusal reason = Refusal::count;
  if (log.robot == config.self && log.incarnation == config.incarnation)
    reason = Refusal::own_log_ahead;  // nobody else writes this life's logs
  else if (record.id.seq != held(log))
    reason = Refusal::data_unasked;
  if (reason != Refusal::count) return refuse(reason), reason;
  reason = fetcher.take(now, std::move(record), by);
  take_fetched();
  return reason;
}

void Node::Impl::on_pong(Peer& peer, const wire::Pong& pong) {
  if (const auto time = peer.pings.answered(now, pong.token)) peer.round_trip.sample(*time);
}

void Node::Impl::on_mass(Peer& peer, const wire::Mass& mass) {
  peer.word.loss_there = mass.heard == 0 ? std::nullopt : std::optional(1.0 - mass.heard / 65535.0);
  peer.word.neighbours = std::max<std::size_t>(mass.neighbours, 1);
  if (!talks.heard(now, peer.who.robot, mass, peer.round_trip.smoothed() / 2)) refuse(Refusal::bad_mass);
}

void Node::Impl::on_feedback(Peer& peer, const wire::Feedback& feedback) { peer.rate.feedback(now, feedback); }

void Node::Impl::on_later_life(const wire::LaterLife& later) {
  if (later.robot != config.self) return refuse(Refusal::wrong_receiver);
  if (!wire::is_life(later.incarnation)) return refuse(Refusal::bad_incarnation);
  if (later.incarnation > config.incarnation) outlived = std::max(outlived.value_or(0), later.incarnation);
}

}  // namespace onemap::comms
