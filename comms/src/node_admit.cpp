// Who may speak: greetings, proofs, places.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
constexpr auto kNamedCandidateStays = std::chrono::seconds(2);
constexpr std::size_t kMaxAnswers = 64;

template <class T>
const T* first_of(std::span<const wire::Frame> frames) {
  for (const wire::Frame& frame : frames)
    if (const auto* found = std::get_if<T>(&frame)) return found;
  return nullptr;
}
}  // namespace

// Who repeats our incarnation has heard us at this address.
bool Node::Impl::names_us(const wire::Header& header) const {
  return header.type == wire::DatagramType::unicast && header.receiver == config.incarnation;
}

const Link* Node::Impl::living(const RobotId& robot) const {
  for (const auto& [endpoint, link] : links)
    if (link.alive && link.robot == robot) return &link;
  return nullptr;
}

// Which neighbour speaks, or nobody, and then the datagram is refused and counted.
Link* Node::Impl::admit(const Endpoint& from, const wire::Header& header, std::span<const wire::Frame> frames) {
  if (const auto* beacon = first_of<wire::Beacon>(frames)) return admit_greeting(from, header, *beacon);
  const auto at = links.find(from);
  if (at == links.end() || header.type != wire::DatagramType::unicast) return refuse(Refusal::stranger), nullptr;
  Link& link = at->second;
  const auto* later = first_of<wire::LaterLife>(frames);
  if (later != nullptr && frames.size() == 1 && names_us(header)) return on_later_life(*later), nullptr;
  if (link.incarnation != header.sender) return admit_candidate(link, header, frames);
  if (!names_us(header)) return refuse(Refusal::wrong_receiver), nullptr;
  return &link;
}

// No greeting, and not in the name of who is known here: the answer to our challenge, or nothing.
Link* Node::Impl::admit_candidate(Link& link, const wire::Header& header, std::span<const wire::Frame> frames) {
  const Candidate& candidate = link.candidate;
  const auto* pong = first_of<wire::Pong>(frames);
  if (names_us(header) && pong != nullptr && candidate.incarnation == header.sender && candidate.token != 0 &&
      candidate.token == pong->token) {
    become(link, candidate.robot, candidate.incarnation);
    return &link;
  }
  return refuse(Refusal::stranger), nullptr;
}

Link* Node::Impl::admit_greeting(const Endpoint& from, const wire::Header& header, const wire::Beacon& beacon) {
  if (conflicts(from, header, beacon)) return nullptr;
  const auto at = links.find(from);
  Link* link = at == links.end() ? nullptr : &at->second;
  const bool same = link != nullptr && link->robot == beacon.robot;
  const std::uint64_t known =
      std::max(team.life_in_records(beacon.robot), same && link->proved ? link->incarnation : 0);
  if (header.sender < known) {
    refuse(Refusal::former_life);
    answer_former_life(from, header, {beacon.robot, known});
    return nullptr;
  }
  if (same && link->incarnation == header.sender) return link;
  if (link != nullptr && link->alive) return challenge(*link, header, beacon), nullptr;
  if (link == nullptr) link = room_for(from);
  if (link != nullptr) become(*link, beacon.robot, header.sender);
  return link;
}

// One id twice: ours, or that of a living neighbour. The neighbour that was here first stays; a robot that started
// again at another address gets in when its former life has been silent for half the time limit.
bool Node::Impl::conflicts(const Endpoint& from, const wire::Header& header, const wire::Beacon& beacon) {
  if (beacon.robot == config.self) {
    const bool echo = header.sender == config.incarnation;
    refuse(echo ? Refusal::own_echo : Refusal::id_conflict);
    if (!echo) conflict = IdConflict{from, header.sender, now};
    return true;
  }
  for (const auto& [endpoint, other] : links) {
    if (endpoint == from || !other.alive || other.robot != beacon.robot) continue;
    if (now - other.last_heard > config.neighbour_timeout / 2) continue;
    refuse(other.incarnation == header.sender ? Refusal::second_path : Refusal::id_conflict);
    return true;
  }
  return false;
}

// Somebody else greets from where a living neighbour is: a robot that started again, or a forged address. First it is
// greeted, so that it can name us; then it has to repeat a token. Whoever is living here stays until then.
void Node::Impl::challenge(Link& link, const wire::Header& header, const wire::Beacon& beacon) {
  refuse(Refusal::candidate);
  Candidate& candidate = link.candidate;
  const bool same = candidate.robot == beacon.robot && candidate.incarnation == header.sender;
  if (!same && candidate.stays_until > now) return;
  if (!same) candidate = {beacon.robot, header.sender, false, false, 0, {}};
  if (!names_us(header)) {
    candidate.beacon_due = true;
    return;
  }
  if (candidate.token == 0) candidate.token = static_cast<std::uint32_t>(random.next() >> 32) | 1u;
  candidate.ping_due = true;
  candidate.stays_until = now + kNamedCandidateStays;
}

void Node::Impl::become(Link& link, RobotId robot, std::uint64_t incarnation) {  // robot may be the link's own
  const RobotId before = link.robot;
  fetcher.drop(link);
  link.forget_peer();
  if (link.robot != robot && living(before) == nullptr) team.left(before);
  link.robot = robot;
  link.incarnation = incarnation;
  plan_due = true;
}

// Configured peers and living neighbours keep their places. The others of one address share a part of the table, so
// that one machine cannot fill it; who has not proved to be where it says makes room for who came later.
Link* Node::Impl::room_for(const Endpoint& endpoint) {
  const std::size_t share = std::max<std::size_t>(config.max_neighbours / 4, 1);
  std::size_t neighbours = 0;
  auto oldest = links.end();
  const auto look = [&](bool whole_table) {
    neighbours = 0, oldest = links.end();
    for (auto it = links.begin(); it != links.end(); ++it) {
      const Link& link = it->second;
      if (!whole_table && (link.configured || it->first.address != endpoint.address)) continue;
      ++neighbours;
      if (link.alive || link.configured) continue;
      if (oldest == links.end() || link.last_heard < oldest->second.last_heard) oldest = it;
    }
    return neighbours < (whole_table ? config.max_neighbours : share);
  };
  for (const bool whole_table : {false, true}) {
    if (look(whole_table)) continue;
    if (oldest == links.end()) return refuse(whole_table ? Refusal::neighbours_full : Refusal::address_full), nullptr;
    fetcher.drop(oldest->second);
    links.erase(oldest);
  }
  Link& link = links[endpoint];
  link.endpoint = endpoint;
  return &link;
}

void Node::Impl::answer_former_life(const Endpoint& to, const wire::Header& header, const wire::LaterLife& later) {
  if (answers.size() < kMaxAnswers) answers.push_back({to, header.sender, later});
}

}  // namespace onemap::comms
