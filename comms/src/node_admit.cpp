// Who may speak: greetings, proofs, places.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
constexpr std::size_t kMaxAnswers = 64;

template <class T>
const T* first_of(std::span<const wire::Frame> frames) {
  for (const wire::Frame& frame : frames)
    if (const auto* found = std::get_if<T>(&frame)) return found;
  return nullptr;
}
}  // namespace

bool Node::Impl::names_us(const wire::Header& header) const { return Session::proves(header, config.incarnation); }

const Peer* Node::Impl::living(const RobotId& robot) const {
  for (const auto& [endpoint, peer] : peers)
    if (peer.who.alive && peer.who.robot == robot) return &peer;
  return nullptr;
}

// Which neighbour speaks, or nobody, and then the datagram is refused and counted.
Peer* Node::Impl::admit(const Endpoint& from, const wire::Header& header, std::span<const wire::Frame> frames) {
  if (const auto* beacon = first_of<wire::Beacon>(frames)) return admit_greeting(from, header, beacon->robot);
  const auto at = peers.find(from);
  if (at == peers.end() || header.type != wire::DatagramType::unicast) return refuse(Refusal::stranger), nullptr;
  Peer& peer = at->second;
  const auto* later = first_of<wire::LaterLife>(frames);
  if (later != nullptr && frames.size() == 1 && names_us(header)) return on_later_life(*later), nullptr;
  if (peer.who.incarnation != header.sender) return admit_candidate(peer, header, frames);
  if (!names_us(header)) return refuse(Refusal::wrong_receiver), nullptr;
  return &peer;
}

// No greeting, and not in the name of who is known here: the answer to our challenge, or nothing.
Peer* Node::Impl::admit_candidate(Peer& peer, const wire::Header& header, std::span<const wire::Frame> frames) {
  const auto* pong = first_of<wire::Pong>(frames);
  const Candidate* const proved =
      pong != nullptr && names_us(header) ? peer.candidates.proved(header.sender, pong->token) : nullptr;
  if (proved != nullptr) {
    become(peer, proved->robot, proved->incarnation);
    return &peer;
  }
  return refuse(Refusal::stranger), nullptr;
}

Peer* Node::Impl::admit_greeting(const Endpoint& from, const wire::Header& header, const RobotId& robot) {
  if (conflicts(from, header, robot)) return nullptr;
  const auto at = peers.find(from);
  Peer* peer = at == peers.end() ? nullptr : &at->second;
  const bool same = peer != nullptr && peer->who.robot == robot;
  const std::uint64_t known =
      std::max(team.life_in_records(robot), same && peer->who.proved ? peer->who.incarnation : 0);
  if (header.sender < known) {
    refuse(Refusal::former_life);
    answer_former_life(from, header, {robot, known});
    return nullptr;
  }
  if (same && peer->who.incarnation == header.sender) return peer;
  if (peer != nullptr && peer->who.alive && !(config.sealed && names_us(header)))
    return challenge(*peer, header, robot), nullptr;
  if (peer == nullptr) peer = room_for(from);
  if (peer != nullptr) become(*peer, robot, header.sender);
  return peer;
}

// One id twice: ours, or that of a living neighbour. The neighbour that was here first stays; a robot that started
// again at another address gets in when its former life has been silent for half the time limit.
bool Node::Impl::conflicts(const Endpoint& from, const wire::Header& header, const RobotId& robot) {
  if (robot == config.self) {
    const bool echo = header.sender == config.incarnation;
    refuse(echo ? Refusal::own_echo : Refusal::id_conflict);
    if (!echo) conflict = IdConflict{from, header.sender, now};
    return true;
  }
  for (auto& [endpoint, other] : peers) {
    if (endpoint == from || !other.who.alive || other.who.robot != robot) continue;
    if (now - other.who.last_heard > config.neighbour_timeout / 2) continue;
    const bool proved = config.sealed && names_us(header);
    if (proved && header.sender > other.who.incarnation) continue;  // it started again, and has its key to say so
    if (config.sealed && header.sender == other.who.incarnation && !is_still_there(other)) continue;
    refuse(other.who.incarnation == header.sender ? Refusal::second_path : Refusal::id_conflict);
    return true;
  }
  return false;
}

// A neighbour is heard elsewhere, too. Where it was may be a way that ended, or somebody who passed on a handshake and
// nothing more: it is asked, and who does not answer is not there.
bool Node::Impl::is_still_there(Peer& peer) {
  constexpr auto kLately = std::chrono::seconds(2);
  if (peer.who.doubtful) return false;
  if (now - peer.who.last_heard < kLately) return true;
  ask_whether_there(peer);
  return true;
}

void Node::Impl::ask_whether_there(Peer& peer) {
  constexpr auto kPatience = std::chrono::milliseconds(600);
  if (peer.who.asked_until) return;
  peer.who.asked_until = now + kPatience;
  peer.pings.due = true;
}

// Somebody else greets from where a living neighbour is: a robot that started again, or a forged address. First it is
// greeted, so that it can name us; then it has to repeat a token. Whoever is living here stays until then.
void Node::Impl::challenge(Peer& peer, const wire::Header& header, const RobotId& robot) {
  refuse(Refusal::candidate);
  peer.candidates.greeted(now, robot, header.sender, names_us(header), random);
}

void Node::Impl::become(Peer& peer, const RobotId& robot, std::uint64_t incarnation) {
  const RobotId before = peer.who.robot;
  fetcher.drop(peer);
  peer.become(robot, incarnation, memory);
  if (before != peer.who.robot && living(before) == nullptr) team.left(before);
  plan_due = true;
}

// Configured peers and living neighbours keep their places. The others of one address share a part of the table, so
// that one machine cannot fill it; who has not proved to be where it says makes room for who came later.
Peer* Node::Impl::room_for(const Endpoint& endpoint) {
  const std::size_t share = std::max<std::size_t>(config.max_neighbours / 4, 1);
  std::size_t neighbours = 0;
  auto oldest = peers.end();
  const auto look = [&](bool whole_table) {
    neighbours = 0, oldest = peers.end();
    for (auto it = peers.begin(); it != peers.end(); ++it) {
      const Peer& peer = it->second;
      if (!whole_table && (peer.configured || it->first.address != endpoint.address)) continue;
      ++neighbours;
      if (peer.who.alive || peer.configured) continue;
      if (oldest == peers.end() || peer.who.last_heard < oldest->second.who.last_heard) oldest = it;
    }
    return neighbours < (whole_table ? config.max_neighbours : share);
  };
  for (const bool whole_table : {false, true}) {
    if (look(whole_table)) continue;
    if (oldest == peers.end()) return refuse(whole_table ? Refusal::neighbours_full : Refusal::address_full), nullptr;
    forget(oldest);
  }
  Peer& peer = place(endpoint);
  prepare(peer);
  peer.session.count_from(counted_to);
  return &peer;
}

void Node::Impl::forget(Peers::iterator peer) {
  counted_to = std::max(counted_to, peer->second.session.counter());
  fetcher.drop(peer->second);
  peers.erase(peer);
}

// It goes on under its new address with all that is known of it; a configured address stays one that is greeted.
void Node::Impl::moved(const Endpoint& from, const Endpoint& to) {
  const auto there = peers.find(to);
  if (from == to || !peers.contains(from) || (there != peers.end() && there->second.who.alive)) return;
  if (there != peers.end()) forget(there);
  auto entry = peers.extract(from);
  entry.key() = entry.mapped().endpoint = to;
  if (std::exchange(entry.mapped().configured, false)) {
    Peer& again = place(from);
    again.configured = again.ever_heard = true;
    again.session.count_from(counted_to);
    again.rate = RateController(rate_bounds(config), memory);
  }
  peers.insert(std::move(entry));
  plan_due = true;
}

void Node::Impl::answer_former_life(const Endpoint& to, const wire::Header& header, const wire::LaterLife& later) {
  if (answers.size() < kMaxAnswers) answers.push_back({to, header.sender, later});
}

}  // namespace onemap::comms
