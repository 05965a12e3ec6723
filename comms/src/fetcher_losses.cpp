#include <algorithm>

#include "fetcher.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
constexpr unsigned kSilencesToRetarget = 3;
constexpr auto kAvoid = milliseconds(1000);
}  // namespace

void Fetcher::on_timer(Instant now, Links& links) {
  for (auto& [endpoint, link] : links) {
    for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) {
      lose_suspects(now, link, lane);
      lose_silent(now, link, lane);
    }
    if (link.silences >= kSilencesToRetarget) retarget(now, link, links);
  }
  std::vector<LogId> again;
  for (const auto& [log, blocked] : blocked_)
    if (blocked.again <= now) again.push_back(log);
  for (const LogId& log : again) store_in_order(now, log);
  if (wake_ > now) return;
  wake_ = Instant::max();
  for (const auto& [id, fetch] : fetches_)
    if (fetch.not_before > now) wake_ = std::min(wake_, fetch.not_before);
}

Instant Fetcher::next_deadline(const Links& links) const {
  Instant next = Instant::max();
  for (const auto& [endpoint, link] : links)
    for (const AskLane& lane : link.lanes) {
      if (lane.outstanding == 0) continue;
      next = std::min(next, lane.progress + link.round_trip.give_up_after(link.silences));
      if (lane.suspect_since) next = std::min(next, *lane.suspect_since + link.round_trip.reorder_window());
    }
  for (const auto& [log, blocked] : blocked_) next = std::min(next, blocked.again);
  next = std::min(next, wake_);
  return next;
}

void Fetcher::lose_suspects(Instant now, Link& link, std::uint8_t lane_index) {
  AskLane& lane = link.lanes[lane_index];
  const Duration window = link.round_trip.reorder_window();
  if (!lane.suspect_since || *lane.suspect_since + window > now) return;
  lane.suspect_since.reset();
  for (Ask& ask : lane.asks) {
    if (ask.done || !ask.overtaken_at) continue;
    if (*ask.overtaken_at + window <= now) {
      lose(lane, ask);
    } else if (!lane.suspect_since || *ask.overtaken_at < *lane.suspect_since) {
      lane.suspect_since = ask.overtaken_at;
    }
  }
  trim(lane);
}

void Fetcher::lose_silent(Instant now, Link& link, std::uint8_t lane_index) {
  AskLane& lane = link.lanes[lane_index];
  if (lane.outstanding == 0 || lane.progress + link.round_trip.give_up_after(link.silences) > now) return;
  for (Ask& ask : lane.asks)
    if (!ask.done) lose(lane, ask);
  trim(lane);
  ++link.silences;
}

void Fetcher::lose(AskLane& lane, Ask& ask) {
  ask.done = true;
  --lane.outstanding;
  const auto at = fetches_.find(ask.id);
  if (at == fetches_.end() || ask.fragment >= at->second.fragments.size()) return;
  Fetch& fetch = at->second;
  fetch.fragments[ask.fragment] = kMissing;
  ++fetch.missing;
  note_need(ask.id, fetch);
  ++counters_.fragments_reasked;
}

void Fetcher::retarget(Instant now, Link& silent, Links& links) {
  silent.avoid_until = now + kAvoid;
  for (auto& [id, fetch] : fetches_) {
    if (fetch.target != &silent || fetch.complete) continue;
    Link* other = choose(now, id, links, &silent);
    if (other == nullptr) continue;
    release(id, fetch);
    fetch.target = other;
    ++counters_.records_retargeted;
  }
}

void Fetcher::drop(Link& link) {
  for (auto& [id, fetch] : fetches_) {
    if (fetch.target != &link) continue;
    release(id, fetch);
    fetch.target = nullptr;
  }
  for (AskLane& lane : link.lanes) lane = {};
  link.wants.clear();
  link.want_at.reset();
}

void Fetcher::abandon(const std::function<bool(const LogId&)>& which) {
  std::vector<RecordId> records;
  for (const auto& [id, fetch] : fetches_)
    if (which(id.log)) records.push_back(id);
  for (const RecordId& id : records) close(id);
  for (auto& lane : lacking_) std::erase_if(lane, [&](const auto& entry) { return which(entry.first); });
  std::erase_if(blocked_, [&](const auto& entry) { return which(entry.first); });
}

void Fetcher::release(const RecordId& id, Fetch& fetch) {
  if (fetch.target != nullptr) {
    AskLane& lane = fetch.target->lanes[id.log.lane];
    for (Ask& ask : lane.asks) {
      if (ask.done || ask.id != id) continue;
      ask.done = true;
      --lane.outstanding;
    }
    trim(lane);
  }
  fetch.missing = 0;
  for (std::uint32_t& state : fetch.fragments) {
    if (state != kReceived) state = kMissing;
    if (state == kMissing) ++fetch.missing;
  }
  note_need(id, fetch);
}

void Fetcher::cut(const RecordId& id, Fetch& fetch, std::uint32_t count) {
  if (fetch.target == nullptr || fetch.fragments.size() <= count) return;
  AskLane& lane = fetch.target->lanes[id.log.lane];
  for (Ask& ask : lane.asks) {
    if (ask.done || ask.id != id || ask.fragment < count) continue;
    ask.done = true;
    --lane.outstanding;
  }
}

void Fetcher::restart(const RecordId& id, Fetch& fetch) {
  std::fill(fetch.fragments.begin(), fetch.fragments.end(), kMissing);
  release(id, fetch);
  fetch.known = false;
  fetch.received = 0;
  fetch.hops = 0;
}

void Fetcher::close(const RecordId& id) {
  const auto at = fetches_.find(id);
  release(id, at->second);
  needs_[id.log.lane].erase(id);
  used_bytes_ -= at->second.reserved_bytes;
  fetches_.erase(at);
  std::uint32_t& next = lacking_[id.log.lane].try_emplace(id.log, id.seq).first->second;
  next = std::min(next, id.seq);
}

void Fetcher::trim(AskLane& lane) {
  while (!lane.asks.empty() && lane.asks.front().done) lane.asks.pop_front();
  if (lane.outstanding == 0) lane.suspect_since.reset();
}

}  // namespace onemap::comms
