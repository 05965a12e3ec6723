#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr auto kBeaconGap = milliseconds(100);  // beacons on change are not sent faster
constexpr auto kRefusedLogsRetry = std::chrono::seconds(4);
constexpr auto kUnequalInterval = milliseconds(500);  // while a neighbour's digest differs from ours
}  // namespace

void Node::Impl::tick() {
  for (auto& [endpoint, link] : links) tick(link);
  if (now >= beacon_at) beacon_all();
  fetcher.on_timer(now, links);
  for (const Fetcher::Stored& record : fetcher.take_stored()) stored(record.id, record.hops);
  plan_due = true;
}

void Node::Impl::tick(Link& link) {
  if (!link.alive) return;
  if (now - link.last_heard >= config.neighbour_timeout) return link_down(link);
  if (link.request_have_at && *link.request_have_at <= now) {
    link.have_request_due = true;
    link.last_have_request = now;
    const unsigned slower = std::clamp(link.have_requests, 6u, 11u) - 6u;
    link.request_have_at =
        not_too_often(link, now + (milliseconds(50) + 2 * link.round_trip.smoothed()) * (1u << slower));
    ++link.have_requests;
  }
  if (link.outstanding() > 0 && now >= link.next_ping) link.ping_due = true;
}

// What we refused of its frontier will differ again.
Instant Node::Impl::not_too_often(const Link& link, Instant have_request) {
  return link.has_refused_logs ? std::max(have_request, link.last_have_request + kRefusedLogsRetry) : have_request;
}

void Node::Impl::link_down(Link& link) {
  link.alive = false;
  ++counters.neighbours_lost;
  fetcher.drop(link);
  if (living(link.robot) == nullptr) team.left(link.robot);
  link.serve = {};
  link.have_dirty.clear();
  link.have_at.reset();
  link.request_have_at.reset();
}

void Node::Impl::tell_all(Link& link) {
  for (const auto& [log, count] : store.frontier()) link.have_dirty.insert(log);
  if (!link.have_dirty.empty()) link.have_at = now;
}

void Node::Impl::changed() {
  beacon_interval = config.beacon_min;
  beacon_at = std::min(beacon_at, std::max(now, last_beacon + kBeaconGap));
}

bool Node::Impl::all_consistent() const {
  return std::all_of(links.begin(), links.end(), [&](const auto& entry) {
    return !entry.second.alive || entry.second.claimed_digest == frontier_digest;
  });
}

void Node::Impl::beacon_all() {
  for (auto& [endpoint, link] : links)
    if (link.alive || link.configured) link.beacon_due = true;
  group_due = config.group.has_value();
  Duration interval = beacon_interval;
  if (!all_consistent()) interval = std::min<Duration>(interval, kUnequalInterval);
  const auto half = static_cast<std::uint64_t>(interval.count() / 2);
  last_beacon = now;
  beacon_at = now + Duration(static_cast<std::int64_t>(half + random.next() % (half + 1)));
  beacon_interval = std::min(beacon_interval * 2, config.beacon_max);
}

Instant Node::Impl::next_deadline() const {
  if (plan_due || group_due || !answers.empty()) return now;
  Instant next = std::min(beacon_at, fetcher.next_deadline(links));
  for (const auto& [endpoint, link] : links) next = std::min(next, next_deadline(link));
  return std::max(next, now);
}

Instant Node::Impl::next_deadline(const Link& link) const {
  if (control_ready(link)) return now;
  if (!link.alive) return Instant::max();
  Instant next = link.last_heard + config.neighbour_timeout;
  if (link.request_have_at) next = std::min(next, *link.request_have_at);
  if (link.have_at) next = std::min(next, *link.have_at);
  if (link.want_at) next = std::min(next, *link.want_at);
  if (link.outstanding() > 0) next = std::min(next, link.next_ping);
  if (!link.serve.empty()) next = std::min(next, pace_at);
  return next;
}

}  // namespace onemap::comms
