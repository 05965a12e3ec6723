// What a neighbour says.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr std::size_t kMaxServeBytes = 2u << 20;  // whatever credit a neighbour gives itself

constexpr auto kTellAuthorGap = std::chrono::seconds(1);
constexpr std::uint64_t kReordered = 64;  // datagrams that may overtake each other
}  // namespace

void Node::Impl::receive(const Endpoint& from, std::span<const std::uint8_t> bytes) {
  ++counters.datagrams_received;
  counters.bytes_received += bytes.size();
  const Refusal verdict = decoder.decode(bytes);
  if (verdict != Refusal::count) return refuse(verdict);
  const wire::Header& header = decoder.header();
  if (const auto known = links.find(from); known != links.end()) known->second.ever_heard = true;
  Link* link = admit(from, header, decoder.frames());
  if (link == nullptr) return;
  link->bytes_in += bytes.size();
  const bool proved = names_us(header);
  if (proved || !link->alive) link->last_heard = now;
  const bool group = header.type == wire::DatagramType::group;
  if (!proved && !(link->alive && group)) {  // it is worth no more than a short greeting
    ++counters.frames_received[index_of(FrameType::beacon)];
    link->beacon_due = true;
    return;
  }
  const auto arrival = fresh(*link, header);
  if (!arrival) return;
  link->silences = std::min(link->silences, RoundTrip::kPatientSilences);  // it is there: do not wait for seconds
  if (!link->alive) link_up(*link);
  for (const wire::Frame& frame : decoder.frames()) {
    ++counters.frames_received[index_of(wire::type_of(frame))];
    on_frame(*link, *arrival, frame);
  }
}

std::optional<Node::Impl::Arrival> Node::Impl::fresh(Link& link, const wire::Header& header) {
  const bool unicast = header.type == wire::DatagramType::unicast;
  const auto [verdict, at] = (unicast ? link.window : link.group_window).accept(header.counter);
  switch (verdict) {
    case ReceiveWindow::Verdict::fresh:
      return Arrival{unicast, at};
    case ReceiveWindow::Verdict::duplicate:
      refuse(Refusal::duplicate);
      break;
    case ReceiveWindow::Verdict::too_old:
      refuse(Refusal::too_old);
      break;
    case ReceiveWindow::Verdict::jump:
      refuse(Refusal::counter_jump);
      break;
  }
  return std::nullopt;
}

void Node::Impl::link_up(Link& link) {
  link.alive = link.proved = true;
  link.beacon_due = true;
  link.ping_due = true;
  link.have_requests = 0;
  team.met(link.robot, link.incarnation, now);
  // The author is here itself: what others told of later lives of it is not asked for any longer.
  fetcher.abandon([&](const LogId& log) { return log.robot == link.robot && log.incarnation > link.incarnation; });
  tell_all(link);
  for (const auto& [log, count] : link.holds)
    if (count > held(log) && judge(log) == Refusal::count) fetcher.offered(log);
  changed();
  plan_due = true;
}

void Node::Impl::on_frame(Link& link, const Arrival& arrival, const wire::Frame& frame) {
  struct Visitor {
    Impl& node;
    Link& link;
    const Arrival& arrival;
    void operator()(const wire::Beacon& f) const { node.on_beacon(link, arrival, f); }
    void operator()(const wire::Status& f) const {
      for (const RobotStatus& status : f.robots) node.on_status(status);
    }
    void operator()(const wire::Have& f) const { node.on_have(link, arrival, f); }
    void operator()(const wire::HaveRequest&) const { node.on_have_request(link); }
    void operator()(const wire::Want& f) const { node.on_want(link, f); }
    void operator()(const wire::Data& f) const { node.on_data(link, f); }
    void operator()(const wire::Ping& f) const { link.pong_due = f.token; }
    void operator()(const wire::Pong& f) const { node.on_pong(link, f); }
    void operator()(const wire::LaterLife& f) const { node.on_later_life(f); }
  };
  std::visit(Visitor{*this, link, arrival}, frame);
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

// The neighbour says what it holds altogether. When we think otherwise, something was lost: ask, unless the difference
// goes away by itself in a moment.
void Node::Impl::claim(Link& link, std::uint64_t datagram, std::uint64_t digest_there) {
  if (datagram < link.claimed_at && link.claimed_at - datagram <= kReordered) return;
  link.claimed_at = datagram;
  link.claimed_digest = digest_there;
  if (digest_there == link.holds_digest) {
    link.request_have_at.reset();
    link.have_requests = 0;
    link.has_refused_logs = false;
    return;
  }
  // That it speaks makes another try worth while, however many went unanswered.
  const Instant at = not_too_often(link, now + milliseconds(50) + link.round_trip.smoothed());
  link.request_have_at = link.request_have_at ? std::min(*link.request_have_at, at) : at;
}

void Node::Impl::on_beacon(Link& link, const Arrival& arrival, const wire::Beacon& beacon) {
  link.map_digest = beacon.map_digest;
  link.flags = beacon.flags;
  if (arrival.unicast) claim(link, arrival.at, beacon.frontier_digest);
  const auto merged = team.merge(
      {beacon.robot, link.incarnation, beacon.status_counter, beacon.frontier_digest, beacon.map_digest, beacon.flags},
      now);
  if (merged == TeamTable::Merge::newer) changed();
  // Late, or somebody put words into its mouth: it shall hear them, and speak up.
  if (merged == TeamTable::Merge::older) link.status_echo_due = true;
}

void Node::Impl::on_have(Link& link, const Arrival& arrival, const wire::Have& have) {
  for (const wire::HaveEntry& entry : have.entries) on_have(link, entry);
  claim(link, arrival.at, have.frontier_digest);
  plan_due = true;
}

void Node::Impl::on_have(Link& link, const wire::HaveEntry& entry) {
  const std::uint32_t here = held(entry.log);
  const bool own = entry.log.robot == config.self && entry.log.incarnation == config.incarnation;
  auto at = link.holds.find(entry.log);
  Refusal verdict = judge(entry.log);
  if (own && entry.count > here) verdict = Refusal::own_log_ahead;
  if (at == link.holds.end() && link.holds.size() >= config.max_logs) verdict = Refusal::logs_full;
  if (verdict == Refusal::contradicts_author) tell_author(entry.log);
  if (verdict != Refusal::count) {
    link.has_refused_logs = true;
    return refuse(verdict);
  }
  if (at == link.holds.end()) at = link.holds.emplace(entry.log, 0).first;
  if (entry.count <= at->second) return;
  link.holds_digest += entry_digest(entry.log, entry.count) - entry_digest(entry.log, at->second);
  at->second = entry.count;
  if (entry.count > here) fetcher.offered(entry.log);
}

// Somebody believes in a later life of a neighbour of ours than the one in which it lives. It shall hear of that: when
// it goes on after that number, all believe it again.
void Node::Impl::tell_author(const LogId& log) {
  for (auto& [endpoint, link] : links) {
    if (!link.alive || link.robot != log.robot || link.later_life_again > now) continue;
    link.later_life_due = log.incarnation;
    link.later_life_again = now + kTellAuthorGap;
  }
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
    const auto way = hops_of(entry.id).value_or(0);
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

void Node::Impl::on_later_life(const wire::LaterLife& later) {
  if (later.robot != config.self) return refuse(Refusal::wrong_receiver);
  if (!wire::is_life(later.incarnation)) return refuse(Refusal::bad_incarnation);
  if (later.incarnation > config.incarnation) outlived = std::max(outlived.value_or(0), later.incarnation);
}

}  // namespace onemap::comms
