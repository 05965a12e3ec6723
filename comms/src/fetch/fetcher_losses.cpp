// What does not come.
#include <algorithm>

#include "fetch/fetcher.hpp"

namespace onemap::comms {

namespace {
constexpr unsigned kSilencesToRetarget = 3;
}  // namespace

void Fetcher::on_timer(Instant now, Peers& peers) {
  for (auto& [endpoint, peer] : peers) {
    const unsigned silences = peer.asks.silences();
    for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) {
      lose(peer.asks.take_overtaken(now, lane, peer.round_trip.reorder_window()));
      lose(peer.asks.take_silent(now, lane, peer.round_trip));
    }
    if (peer.asks.silences() < kSilencesToRetarget) continue;
    peer.asks.avoid(now);
    if (peer.asks.silences() > silences) retarget(now, peer, peers);
  }
  std::pmr::vector<LogId> again(memory_);
  for (const auto& [log, blocked] : blocked_)
    if (blocked.again <= now) again.push_back(log);
  for (const LogId& log : again) store_in_order(now, log);
  if (wake_ > now) return;
  wake_ = Instant::max();
  for (const auto& [id, fetch] : fetches_)
    if (fetch.not_before > now) wake_ = std::min(wake_, fetch.not_before);
}

Instant Fetcher::next_deadline(const Peers& peers) const {
  Instant next = wake_;
  for (const auto& [endpoint, peer] : peers) next = std::min(next, peer.asks.next_deadline(peer.round_trip));
  for (const auto& [log, blocked] : blocked_) next = std::min(next, blocked.again);
  return next;
}

void Fetcher::lose(const AskLedger::Fragments& fragments) {
  for (const AskLedger::Fragment& fragment : fragments) {
    const auto at = fetches_.find(fragment.id);
    if (at == fetches_.end()) continue;
    at->second.assembly.lost(fragment.index);
    note_need(fragment.id, at->second);
    ++counters_.fragments_reasked;
  }
}

// Somebody else may hold now what was asked of one that does not answer: do not wait until it is silent once more.
void Fetcher::leave_the_silent(Instant now, Peers& peers) {
  for (auto& [endpoint, peer] : peers)
    if (peer.asks.silences() >= kSilencesToRetarget && peer.asks.outstanding() > 0) retarget(now, peer, peers);
}

// To those who were silent less often: two who are silent must not hand their asks to and fro, and what was asked of
// one that lives must not end at one that is out of reach.
void Fetcher::retarget(Instant now, Peer& silent, Peers& peers) {
  for (auto& [id, fetch] : fetches_) {
    if (fetch.target != &silent || fetch.complete()) continue;
    Peer* other = choose(now, id, peers, &silent);
    if (other == nullptr || (other->asks.avoided(now) && other->asks.silences() >= silent.asks.silences())) continue;
    release(id, fetch);
    fetch.target = other;
    ++counters_.records_retargeted;
  }
}

void Fetcher::drop(Peer& peer) {
  for (auto& [id, fetch] : fetches_) {
    if (fetch.target != &peer) continue;
    release(id, fetch);
    fetch.target = nullptr;
  }
  peer.asks.clear();
  peer.outbox.want_nothing();
}

void Fetcher::abandon(const std::function<bool(const LogId&)>& which) {
  std::pmr::vector<RecordId> records(memory_);
  for (const auto& [id, fetch] : fetches_)
    if (which(id.log)) records.push_back(id);
  for (const RecordId& id : records) close(id);
  for (auto& lane : lacking_) std::erase_if(lane, [&](const auto& entry) { return which(entry.first); });
  std::erase_if(blocked_, [&](const auto& entry) { return which(entry.first); });
}

void Fetcher::release(const RecordId& id, Fetch& fetch) {
  if (fetch.target != nullptr) fetch.target->asks.withdraw(id);
  fetch.assembly.withdrawn();
  note_need(id, fetch);
}

void Fetcher::restart(const RecordId& id, Fetch& fetch) {
  release(id, fetch);
  fetch.assembly.restart();
  note_need(id, fetch);
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

}  // namespace onemap::comms
