#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr std::size_t kManyWants = 32;  // a full datagram of them does not wait
constexpr auto kPingGap = milliseconds(200);

// The first entry after `cursor`, going round.
template <class Map, class Key>
auto after(Map& map, const Key& cursor) {
  auto at = map.upper_bound(cursor);
  return at == map.end() ? map.begin() : at;
}
}  // namespace

bool Node::Impl::next_outgoing(OutgoingDatagram& datagram) {
  if (plan_due) fetcher.plan(now, links);
  plan_due = false;
  if (!answers.empty()) return build_answer(datagram), true;
  if (group_due) return build_group(datagram), true;
  auto it = after(links, control_cursor);
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (control_ready(it->second)) {
      control_cursor = it->first;
      const Candidate& candidate = it->second.candidate;
      if (candidate.beacon_due || candidate.ping_due)
        build_candidate(it->second, datagram);
      else
        build_control(it->second, datagram);
      return true;
    }
    if (++it == links.end()) it = links.begin();
  }
  return build_data(datagram);
}

bool Node::Impl::control_ready(const Link& link) const {
  if (link.beacon_due || link.candidate.beacon_due || link.candidate.ping_due) return true;
  if (!link.alive) return false;
  if (link.later_life_due || link.have_request_due || link.pong_due || link.ping_due) return true;
  return (link.have_at && *link.have_at <= now) || (link.want_at && *link.want_at <= now) ||
         link.wants.size() >= kManyWants;
}

wire::Header Node::Impl::header_for(Link& link) {
  return {wire::DatagramType::unicast, config.incarnation, link.incarnation,
          std::exchange(link.next_counter, wire::next_counter(link.next_counter))};
}

// Everything that leaves uses up the rate; only bodies wait for it.
void Node::Impl::sent(OutgoingDatagram& datagram, const Endpoint& to, std::size_t size) {
  datagram.to = to;
  datagram.size = size;
  ++counters.datagrams_sent;
  counters.bytes_sent += size;
  const std::uint64_t rate = std::max<std::uint64_t>(config.bytes_per_second, 1);
  const auto cost = [&](std::uint64_t bytes) {
    return Duration(static_cast<std::int64_t>(bytes * 1'000'000'000u / rate));
  };
  const std::uint64_t train = std::max<std::size_t>(config.train_datagrams, 1) - 1;
  pace_at = std::max(pace_at, now - cost(train * kMaxDatagramBytes)) + cost(size);
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

void Node::Impl::put_have(wire::Encoder& out, Link& link) {
  have_scratch.clear();
  for (const LogId& log : link.have_dirty) have_scratch.push_back({log, held(log)});
  const std::size_t n = out.have(frontier_digest, have_scratch);
  if (n == 0) return;
  for (std::size_t i = 0; i < n; ++i) link.have_dirty.erase(have_scratch[i].log);
  if (link.have_dirty.empty()) link.have_at.reset();
  link.last_have = now;
  count_sent(FrameType::have);
}

void Node::Impl::put_wants(wire::Encoder& out, Link& link) {
  const std::size_t n = out.want(static_cast<std::uint32_t>(fetcher.credit_to_announce()), link.wants);
  if (n == 0) return;
  link.wants.erase(link.wants.begin(), link.wants.begin() + static_cast<std::ptrdiff_t>(n));
  link.want_at = link.wants.empty() ? std::nullopt : std::optional(now);
  count_sent(FrameType::want);
}

void Node::Impl::build_group(OutgoingDatagram& datagram) {
  group_due = false;
  wire::Encoder out(datagram.buffer, {wire::DatagramType::group, config.incarnation, 0, group_counter});
  group_counter = wire::next_counter(group_counter);
  put_beacon(out);
  put_status(out, config.self, group_cursor);
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
void Node::Impl::build_candidate(Link& link, OutgoingDatagram& datagram) {
  Candidate& candidate = link.candidate;
  wire::Header header = header_for(link);
  header.receiver = candidate.incarnation;
  wire::Encoder out(datagram.buffer, header);
  if (std::exchange(candidate.ping_due, false)) {
    out.ping(candidate.token);
    count_sent(FrameType::ping);
  } else {
    put_beacon(out);
  }
  candidate.beacon_due = false;
  link.bytes_out += out.size();
  sent(datagram, link.endpoint, out.size());
}

void Node::Impl::build_control(Link& link, OutgoingDatagram& datagram) {
  wire::Encoder out(datagram.buffer, header_for(link));
  const bool beacon = std::exchange(link.beacon_due, false);
  if (beacon) put_beacon(out);
  if (link.alive) {  // a stranger gets no more than it sent
    put_round_trip(out, link);
    if (link.later_life_due && out.later_life({link.robot, *link.later_life_due})) {
      link.later_life_due.reset();
      count_sent(FrameType::later_life);
    }
    if (link.have_request_due && out.have_request()) {
      link.have_request_due = false;
      count_sent(FrameType::have_request);
    }
    if (!link.wants.empty()) put_wants(out, link);
    // A beacon's digest must not run ahead of what the neighbour was told.
    if (!link.have_dirty.empty() && (beacon || (link.have_at && *link.have_at <= now))) put_have(out, link);
    if (beacon)
      put_status(out, std::exchange(link.status_echo_due, false) ? RobotId{} : link.robot, link.status_cursor);
  }
  link.bytes_out += out.size();
  sent(datagram, link.endpoint, out.size());
}

void Node::Impl::put_round_trip(wire::Encoder& out, Link& link) {
  if (link.pong_due && out.pong(*std::exchange(link.pong_due, std::nullopt))) count_sent(FrameType::pong);
  if (!link.ping_due || !out.ping(link.ping_token + 1)) return;
  ++link.ping_token;
  link.ping_due = false;
  link.ping_sent = now;
  link.next_ping = now + kPingGap;
  count_sent(FrameType::ping);
}

bool Node::Impl::build_data(OutgoingDatagram& datagram) {
  if (pace_at > now) return false;
  for (std::uint8_t first_lane = 0; first_lane < kLaneCount; ++first_lane) {
    auto it = after(links, data_cursor[first_lane]);
    for (std::size_t i = 0; i < links.size(); ++i) {
      Link& link = it->second;
      if (++it == links.end()) it = links.begin();
      if (!link.alive || link.serve.empty(first_lane)) continue;
      data_cursor[first_lane] = link.endpoint;
      wire::Encoder out(datagram.buffer, header_for(link));
      for (std::uint8_t lane = first_lane; lane < kLaneCount; ++lane) {
        while (!link.serve.empty(lane)) {
          const wire::Data data = link.serve.front(lane);
          if (!out.data(data)) break;
          counters.body_bytes_sent += data.bytes.size();
          count_sent(FrameType::data);
          link.serve.pop(lane);
        }
      }
      link.bytes_out += out.size();
      sent(datagram, link.endpoint, out.size());
      return true;
    }
  }
  return false;
}

}  // namespace onemap::comms
