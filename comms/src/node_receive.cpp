#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr std::size_t kMaxServeBytes = 2u << 20;  // whatever credit a neighbour gives itself

const wire::Beacon* beacon_in(std::span<const wire::Frame> frames) {
  for (const wire::Frame& frame : frames)
    if (const auto* beacon = std::get_if<wire::Beacon>(&frame)) return beacon;
  return nullptr;
}
}  // namespace

void Node::Impl::receive(const Endpoint& from, std::span<const std::uint8_t> bytes) {
  ++counters.datagrams_received;
  counters.bytes_received += bytes.size();
  const Refusal verdict = decoder.decode(bytes);
  if (verdict != Refusal::count) return refuse(verdict);
  const wire::Header& header = decoder.header();
  const wire::Beacon* beacon = beacon_in(decoder.frames());
  Link* link = admit(from, header, beacon);
  if (link == nullptr || !fresh(*link, header)) return;
  link->bytes_in += bytes.size();
  link->last_heard = now;
  link->silences = std::min(link->silences, RoundTrip::kPatientSilences);  // it is there: do not wait for seconds
  // Who repeats our incarnation has heard us at this address: only then it is worth more than a short greeting.
  const bool proved = header.type == wire::DatagramType::unicast && header.receiver == config.incarnation;
  if (proved && !link->alive) link_up(*link);
  if (!proved && !(link->alive && header.type == wire::DatagramType::group)) {
    ++counters.frames_received[static_cast<std::size_t>(FrameType::beacon)];
    link->beacon_due = true;
    return;
  }
  for (const wire::Frame& frame : decoder.frames()) {
    ++counters.frames_received[static_cast<std::size_t>(wire::type_of(frame))];
    on_frame(*link, frame);
  }
}

// Which neighbour speaks, or nobody, and then the datagram is refused and counted.
Link* Node::Impl::admit(const Endpoint& from, const wire::Header& header, const wire::Beacon* beacon) {
  if (beacon != nullptr) return admit_greeting(from, header, *beacon);
  const auto at = links.find(from);
  if (at == links.end() || at->second.incarnation != header.sender || header.type != wire::DatagramType::unicast)
    return refuse(Refusal::stranger), nullptr;
  if (header.receiver != config.incarnation) return refuse(Refusal::wrong_receiver), nullptr;
  return &at->second;
}

Link* Node::Impl::admit_greeting(const Endpoint& from, const wire::Header& header, const wire::Beacon& beacon) {
  if (beacon.robot == config.self) {
    refuse(header.sender == config.incarnation ? Refusal::own_echo : Refusal::id_conflict);
    return nullptr;
  }
  // Two live neighbours with one id: the one that was here first stays. A robot that started again at another address
  // gets in when its former life has been silent for half the time limit.
  for (const auto& [endpoint, other] : links) {
    if (endpoint == from || !other.alive || other.robot != beacon.robot) continue;
    if (now - other.last_heard > config.neighbour_timeout / 2) continue;
    refuse(other.incarnation == header.sender ? Refusal::second_path : Refusal::id_conflict);
    return nullptr;
  }
  const auto at = links.find(from);
  Link* link = at == links.end() ? room_for(from) : &at->second;
  if (link == nullptr) return refuse(Refusal::neighbours_full), nullptr;
  if (link->robot == beacon.robot && header.sender < link->incarnation) return refuse(Refusal::too_old), nullptr;
  if (link->robot != beacon.robot || link->incarnation != header.sender) {
    fetcher.drop(*link);
    link->forget_peer();
    link->robot = beacon.robot;
    link->incarnation = header.sender;
    plan_due = true;
  }
  return link;
}

Link* Node::Impl::room_for(const Endpoint& endpoint) {
  if (links.size() >= config.max_neighbours) {
    auto oldest = links.end();
    for (auto it = links.begin(); it != links.end(); ++it) {
      if (it->second.alive || it->second.configured) continue;
      if (oldest == links.end() || it->second.last_heard < oldest->second.last_heard) oldest = it;
    }
    if (oldest == links.end()) return nullptr;
    fetcher.drop(oldest->second);
    links.erase(oldest);
  }
  Link& link = links[endpoint];
  link.endpoint = endpoint;
  return &link;
}

bool Node::Impl::fresh(Link& link, const wire::Header& header) {
  ReceiveWindow& window = header.type == wire::DatagramType::group ? link.group_window : link.window;
  switch (window.accept(header.counter)) {
    case ReceiveWindow::Verdict::fresh:
      return true;
    case ReceiveWindow::Verdict::duplicate:
      refuse(Refusal::duplicate);
      break;
    case ReceiveWindow::Verdict::too_old:
      refuse(Refusal::too_old);
      break;
  }
  return false;
}

void Node::Impl::link_up(Link& link) {
  link.alive = true;
  link.beacon_due = true;
  link.ping_due = true;
  link.have_requests = 0;
  tell_all(link);
  for (const auto& [log, count] : link.holds)
    if (count > held(log)) fetcher.offered(log);
  changed();
  plan_due = true;
}

void Node::Impl::on_frame(Link& link, const wire::Frame& frame) {
  struct Visitor {
    Impl& node;
    Link& link;
    void operator()(const wire::Beacon& f) const { node.on_beacon(link, f); }
    void operator()(const wire::Status& f) const {
      for (const RobotStatus& status : f.robots) node.merge(status);
    }
    void operator()(const wire::Have& f) const { node.on_have(link, f); }
    void operator()(const wire::HaveRequest&) const { node.on_have_request(link); }
    void operator()(const wire::Want& f) const { node.on_want(link, f); }
    void operator()(const wire::Data& f) const { node.on_data(link, f); }
    void operator()(const wire::Ping& f) const { link.pong_due = f.token; }
    void operator()(const wire::Pong& f) const { node.on_pong(link, f); }
  };
  std::visit(Visitor{*this, link}, frame);
}

void Node::Impl::merge(const RobotStatus& status) {
  switch (team.merge(status)) {
    case TeamTable::Merge::newer:
      changed();
      break;
    case TeamTable::Merge::known:
      break;
    case TeamTable::Merge::full:
      refuse(Refusal::robots_full);
      break;
    case TeamTable::Merge::about_self:
      refuse(Refusal::id_conflict);
      break;
  }
}

// The neighbour says what it holds altogether. When we think otherwise, something was lost: ask, unless the difference
// goes away by itself in a moment.
void Node::Impl::claim(Link& link, std::uint64_t digest_there) {
  if (decoder.header().counter < link.claimed_at) return;
  link.claimed_at = decoder.header().counter;
  link.claimed_digest = digest_there;
  if (digest_there == link.holds_digest) {
    link.request_have_at.reset();
    link.have_requests = 0;
  } else {  // that it speaks makes another try worth while, however many went unanswered
    const Instant at = now + milliseconds(50) + link.round_trip.smoothed();
    link.request_have_at = link.request_have_at ? std::min(*link.request_have_at, at) : at;
  }
}

void Node::Impl::on_beacon(Link& link, const wire::Beacon& beacon) {
  link.map_digest = beacon.map_digest;
  link.flags = beacon.flags;
  if (decoder.header().type == wire::DatagramType::unicast) claim(link, beacon.frontier_digest);
  merge(
      {beacon.robot, link.incarnation, beacon.status_counter, beacon.frontier_digest, beacon.map_digest, beacon.flags});
}

void Node::Impl::on_have(Link& link, const wire::Have& have) {
  for (const wire::HaveEntry& entry : have.entries) {
    const bool own = entry.log.robot == config.self && entry.log.incarnation == config.incarnation;
    const std::uint32_t here = held(entry.log);
    if (own && entry.count > here) {
      refuse(Refusal::own_log_ahead);
      continue;
    }
    auto at = link.holds.find(entry.log);
    if (at == link.holds.end()) {
      if (link.holds.size() >= config.max_logs) {
        refuse(Refusal::logs_full);
        continue;
      }
      at = link.holds.emplace(entry.log, 0).first;
    }
    if (entry.count <= at->second) continue;
    link.holds_digest += entry_digest(entry.log, entry.count) - entry_digest(entry.log, at->second);
    at->second = entry.count;
    if (entry.count > here) fetcher.offered(entry.log);
  }
  claim(link, have.frontier_digest);
  plan_due = true;
}

void Node::Impl::on_have_request(Link& link) {
  constexpr auto kGap = milliseconds(20);
  if (now < link.next_full_have) return;
  link.next_full_have = now + kGap;
  tell_all(link);
}

void Node::Impl::on_want(Link& link, const wire::Want& want) {
  const std::size_t credit = std::min<std::size_t>(want.credit_bytes, kMaxServeBytes);
  for (const wire::WantEntry& entry : want.entries) {
    const auto record = store.find(entry.id);
    if (record == nullptr) {
      refuse(Refusal::want_unknown);
      continue;
    }
    const auto count = wire::fragments_of(static_cast<std::uint32_t>(record->body.size()));
    const std::uint32_t end = std::min<std::uint32_t>(count, std::uint32_t{entry.first} + entry.count);
    if (entry.first >= end) continue;
    const auto way = hops[entry.id.log][entry.id.seq];
    if (link.serve.push(record, hash_of(*record), way, entry.first, end, credit) == ServeQueue::Answer::over_credit)
      refuse(Refusal::want_over_credit);
  }
}

void Node::Impl::on_data(Link& link, const wire::Data& data) {
  fetcher.on_data(now, link, data);
  for (const Fetcher::Stored& record : fetcher.take_stored()) stored(record.id, record.hops);
  plan_due = true;
}

void Node::Impl::on_pong(Link& link, const wire::Pong& pong) {
  if (!link.ping_sent || pong.token != link.ping_token) return;
  link.round_trip.sample(now - *link.ping_sent);
  link.ping_sent.reset();
}

}  // namespace onemap::comms
