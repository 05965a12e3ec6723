// What time brings.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
constexpr unsigned kStatusRounds = 4, kStatusEvery = 32;
constexpr auto kBeaconGap = std::chrono::milliseconds(100), kStatusGap = std::chrono::milliseconds(450);
constexpr auto kUnequalInterval = std::chrono::milliseconds(500);  // while a neighbour's digest differs from ours
}  // namespace

void Node::Impl::tick() {
  if (!undurable.empty() || (sync_at && *sync_at <= now)) {
    sync_at.reset();
    settle_own();
  }
  for (auto& [endpoint, peer] : peers) tick(peer);
  if (trickle.due(now)) beacon_all();
  if (seeking.due(now)) seek();
  if (talks.due(now)) talk();
  fetcher.on_timer(now, peers);
  take_fetched();
}

void Node::Impl::tick(Peer& peer) {
  if (!peer.who.alive) return;
  if (now - peer.who.last_heard >= config.neighbour_timeout) return peer_down(peer);
  if (const auto at = peer.frontier.next_request(); at && *at <= now) {
    peer.outbox.have_request_due = true;
    if (peer.frontier.requested(now, peer.round_trip.smoothed())) fetcher.drop(peer);
  }
  if (peer.who.asked_until && *peer.who.asked_until <= now) {
    peer.who.asked_until.reset();
    peer.who.doubtful = true;
    judge_again();
  }
  peer.outbox.tell_later_life_again(now);
  const bool curious = peer.asks.outstanding() > 0 || peer.who.asked_until;
  if (curious && now >= peer.pings.next()) peer.pings.due = true;
}

void Node::Impl::peer_down(Peer& peer) {
  peer.who.alive = false;
  ++counters.neighbours_lost;
  fetcher.drop(peer);
  if (living(peer.who.robot) == nullptr) team.left(peer.who.robot);
  judge_again();
  talks.team_changed(now);
  peer.serve.clear();
  peer.push.clear();
  peer.outbox.fell_silent();
  peer.frontier.ask_no_more();
}

// Where many are near, something changes all the time and everybody would say so to everybody: the more neighbours, the
// seldomer, so that it stays as much a second as for four. What is news is told at once all the same, by HAVE.
Duration Node::Impl::shared(Duration gap) const {
  constexpr std::ptrdiff_t kFew = 4;
  const auto near = std::ranges::count_if(peers, [](const auto& entry) { return entry.second.who.alive; });
  return gap * std::max(near, kFew) / kFew;
}

void Node::Impl::changed() {
  trickle.changed(now, shared(kBeaconGap));
  seeking.changed(now);
}

bool Node::Impl::all_consistent() const {
  return std::all_of(peers.begin(), peers.end(), [&](const auto& entry) {
    return !entry.second.who.alive || entry.second.frontier.claimed_digest() == frontier_digest;
  });
}

void Node::Impl::beacon_all() {
  for (auto& [endpoint, peer] : peers)
    if (peer.who.alive) peer.outbox.beacon_due = true;
  // What everybody has heard by now is said seldom.
  quiet_rounds = trickle.quiet() ? quiet_rounds + 1 : 0;
  statuses_due = now >= next_statuses && (quiet_rounds < kStatusRounds || quiet_rounds % kStatusEvery == 0);
  if (statuses_due) next_statuses = now + shared(kStatusGap);
  trickle.said(now, all_consistent() ? config.beacon_max : kUnequalInterval, random);
}

// An exchange of the team's talks: everybody near is told what was given.
void Node::Impl::talk() {
  std::pmr::vector<Talks::Near> near(&memory);
  for (auto& [endpoint, peer] : peers)
    if (peer.who.alive) near.push_back({peer.who.robot, peer.word.neighbours});
  if (!talks.exchange(now, near)) return;
  for (auto& [endpoint, peer] : peers)
    if (peer.who.alive) peer.outbox.amounts_due();
}

void Node::Impl::seek() {
  for (auto& [endpoint, peer] : peers)
    if (peer.configured && !peer.who.alive) peer.outbox.beacon_due = true;
  group_due = config.group.has_value();
  seeking.said(now, config.beacon_max, random);
}

Instant Node::Impl::next_deadline() const {
  constexpr auto kLookAgain = std::chrono::milliseconds(2);  // how far the disk has come
  if (plan_due || group_due || !answers.empty()) return now;
  Instant next = std::min({trickle.next(), seeking.next(), talks.next(), fetcher.next_deadline(peers)});
  if (!undurable.empty()) next = std::min(next, now + kLookAgain);
  if (sync_at) next = std::min(next, *sync_at);
  for (const auto& [endpoint, peer] : peers) next = std::min(next, next_deadline(peer));
  return std::max(next, now);
}

Instant Node::Impl::next_deadline(const Peer& peer) const {
  if (control_ready(peer)) return now;
  if (!peer.who.alive) return Instant::max();
  Instant next = peer.who.last_heard + config.neighbour_timeout;
  for (const auto at : {peer.frontier.next_request(), peer.outbox.next()})
    if (at) next = std::min(next, *at);
  if (peer.asks.outstanding() > 0 || peer.who.asked_until) next = std::min(next, peer.pings.next());
  if (peer.who.asked_until) next = std::min(next, *peer.who.asked_until);
  next = std::min({next, peer.arrivals.next(), peer.push.next()});
  const Instant bulk = peer.budget.next(now);
  if (!peer.serve.empty()) {
    const bool urgent = !peer.serve.empty(0) || !peer.serve.empty(1);
    next = std::min(next, std::max({pacer.next(), peer.rate.next(now), urgent ? Instant{} : bulk}));
  }
  if (bulk > now) next = std::min(next, bulk);  // then more may be asked for
  return next;
}

}  // namespace onemap::comms
