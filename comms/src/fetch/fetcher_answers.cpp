// What comes: fragments become records, and records go to the store.
#include <algorithm>
#include <limits>

#include "comms/wire/payload.hpp"
#include "fetch/fetcher.hpp"

namespace onemap::comms {

namespace {
constexpr std::uint32_t kPushedAhead = 64;  // of the first that is missing
constexpr std::size_t kMaxPushed = 1024;    // fetches, with what was asked for
constexpr auto kStoreRetry = std::chrono::milliseconds(1000), kSpoiltRetry = std::chrono::milliseconds(500);
constexpr unsigned kMostDoublings = 4;
}  // namespace

void Fetcher::on_data(Instant now, Peer& from, const wire::Data& data) {
  no_room_for_ = std::numeric_limits<std::size_t>::max();
  const auto at = fetches_.find(data.id);
  if (at == fetches_.end() && takes_unasked(from, data)) return accept_pushed(now, from, data);
  if (at == fetches_.end() || at->second.complete()) {
    if (!repeats_push(data)) counters_.refuse(Refusal::data_unasked);
    counters_.duplicate_body_bytes += data.bytes.size();
    return;
  }
  Fetch& fetch = at->second;
  if (!learn(from, data, fetch)) return;
  const auto serial = fetch.assembly.serial_of(data.fragment);
  if (serial && fetch.target != nullptr) {
    fetch.target->asks.answered(now, data.id.log.lane, *serial);
  } else {
    from.round_trip.was_hasty();
  }
  if (fetch.assembly.keep(data) == Assembly::Kept::again) {
    counters_.duplicate_body_bytes += data.bytes.size();
    return;
  }
  note_need(data.id, fetch);
  counters_.body_bytes_received += data.bytes.size();
  from.asks.progressed(now, data.id.log.lane);
  if (fetch.assembly.complete()) settle(now, from, data.id, fetch);
}

// Its author pushes it, and it is among the next of its log.
bool Fetcher::takes_unasked(const Peer& from, const wire::Data& data) const {
  const LogId& log = data.id.log;
  if (log.lane > wire::kLastPushedLane || wire::fragments_of(data.total_bytes) != 1) return false;
  if (log.robot != from.who.robot || log.incarnation != from.who.incarnation) return false;
  const std::uint32_t have = held(log);
  return data.id.seq >= have && data.id.seq < have + kPushedAhead && !blocked_.contains(log) &&
         fetches_.size() < kMaxPushed && judge_(log) == Refusal::count;
}

bool Fetcher::repeats_push(const wire::Data& data) const {
  return data.id.log.lane <= wire::kLastPushedLane && wire::fragments_of(data.total_bytes) == 1 &&
         (data.id.seq < held(data.id.log) || fetches_.contains(data.id));
}

// Whoever writes a record holds all before it, so what is missing of them is asked for.
void Fetcher::accept_pushed(Instant now, Peer& from, const wire::Data& data) {
  if (wire::body_hash(data.kind, data.bytes) != data.body_hash) return counters_.refuse(Refusal::data_bad_hash);
  if (!make_room(data.id, data.bytes.size())) return counters_.refuse(Refusal::reassembly_full);
  Fetch& fetch = fetches_.try_emplace(data.id, *memory_).first->second;
  fetch.reserved_bytes = data.bytes.size();
  used_bytes_ += fetch.reserved_bytes;
  fetch.assembly.learn(data);
  fetch.assembly.keep(data);
  counters_.body_bytes_received += data.bytes.size();
  ++counters_.records_pushed_here;
  if (from.frontier.raise(data.id.log, data.id.seq + 1)) offered(data.id.log);
  settle(now, from, data.id, fetch);
}

// The first fragment says how large the record is; the others must agree with it.
bool Fetcher::learn(Peer& from, const wire::Data& data, Fetch& fetch) {
  if (fetch.assembly.known()) {
    if (fetch.assembly.agrees(data)) return true;
    counters_.refuse(Refusal::data_conflict);
    if (&from != fetch.target) return false;
    restart(data.id, fetch);  // whom we ask now counts more than whom we asked before
  }
  if (!reserve(data.id, fetch, data.total_bytes)) return false;
  const std::uint32_t count = wire::fragments_of(data.total_bytes);
  if (fetch.target != nullptr) fetch.target->asks.withdraw(data.id, count);
  fetch.assembly.learn(data);
  note_need(data.id, fetch);
  std::uint32_t& guess = guess_[data.id.log.lane];
  guess = std::clamp<std::uint32_t>((3 * guess + count + 2) / 4, 1, kMaxGuess);
  return true;
}

// Makes the fetch's reservation the record's real size, or closes the fetch: then it is opened again, with the size
// known, when there is room.
bool Fetcher::reserve(const RecordId& id, Fetch& fetch, std::uint32_t bytes) {
  const std::size_t more = bytes > fetch.reserved_bytes ? bytes - fetch.reserved_bytes : 0;
  if (!make_room(id, more)) {
    counters_.refuse(Refusal::reassembly_full);
    close(id);
    remember_size(id, bytes);
    return false;
  }
  used_bytes_ += bytes;
  used_bytes_ -= fetch.reserved_bytes;
  fetch.reserved_bytes = bytes;
  return true;
}

// The first missing record of a log may push out records that wait behind others or that nobody can serve now; anything
// else must find room as it is.
bool Fetcher::make_room(const RecordId& id, std::size_t bytes) {
  const auto fits = [&] { return used_bytes_ + bytes <= limits_.reassembly_bytes; };
  if (fits() || id.seq != held(id.log)) return fits();
  if (bytes >= no_room_for_) return false;
  for (auto it = fetches_.end(); it != fetches_.begin() && !fits();) {
    const RecordId victim = (--it)->first;
    const bool moving = victim.seq == held(victim.log) && it->second.target != nullptr;
    if (victim == id || moving) continue;
    const bool known = it->second.assembly.known();
    const std::uint32_t size = it->second.assembly.total_bytes();
    ++it;  // stays valid while its predecessor goes
    close(victim);
    if (known) remember_size(victim, size);
  }
  if (!fits()) no_room_for_ = bytes;
  return fits();
}

void Fetcher::remember_size(const RecordId& id, std::uint32_t bytes) {
  constexpr std::size_t kMaxSizes = 1024;
  if (sizes_.size() >= kMaxSizes) sizes_.clear();
  sizes_[id] = bytes;
}

void Fetcher::settle(Instant now, Peer& from, const RecordId& id, Fetch& fetch) {
  if (!fetch.assembly.hash_is_right()) {
    counters_.refuse(Refusal::data_bad_hash);
    restart(id, fetch);
    from.asks.avoid(now);
    return distrust(now, fetch);
  }
  fetch.whole = true;
  completed(now, from, fetch.assembly.hops(), id.log, fetch);
}

// Its body was dropped where it came from: that is all that there is of it, if what took its place is shown. A body
// that counts is not given up for anybody's word: equal frontiers would be different maps.
void Fetcher::on_head(Instant now, Peer& from, const wire::Head& head) {
  const auto at = fetches_.find(head.record.id);
  if (at == fetches_.end() || at->second.complete()) return counters_.refuse(Refusal::data_unasked);
  Fetch& fetch = at->second;
  release(at->first, fetch);
  fetch.assembly.begin(0);
  note_need(at->first, fetch);
  used_bytes_ -= std::exchange(fetch.reserved_bytes, 0);
  from.asks.progressed(now, at->first.log.lane);
  fetch.head = head;
  completed(now, from, static_cast<std::uint8_t>(std::min(head.hops + 1, 255)), at->first.log, fetch);
}

// The log's name is a copy: the fetch may be over, and with it the id that it came from.
void Fetcher::completed(Instant now, const Peer& from, std::uint8_t hops, LogId log, Fetch& fetch) {
  fetch.verdict.reset();
  fetch.from = from.endpoint;
  fetch.hops = hops;
  store_in_order(now, log);
}

// Bad luck once; what is spoilt again and again is not worth the bandwidth.
void Fetcher::distrust(Instant now, Fetch& fetch) {
  fetch.target = nullptr;
  if (++fetch.bad_bodies == 1) return;
  const unsigned doublings = std::min(fetch.bad_bodies - 2, kMostDoublings);
  fetch.not_before = now + kSpoiltRetry * (1u << doublings);
  wake_ = std::min(wake_, fetch.not_before);
}

// Looked at once, when its predecessor is here. What is not its author's, or not all that counts of it, is asked for
// again, elsewhere if possible; a log whose author contradicts itself ends here.
bool Fetcher::is_authors_next(Instant now, const Record& record, Fetch& fetch) {
  if (!fetch.verdict) fetch.verdict = verdict_of(record, fetch.head ? std::optional(fetch.head->by) : std::nullopt);
  const Refusal reason = fetch.verdict->reason;
  return reason == Refusal::count || spoilt(now, record.id, fetch, reason);
}

Notary::Verdict Fetcher::verdict_of(const Record& record, const std::optional<SignedHead>& by) const {
  Notary::Verdict verdict = notary_.look_at(record);
  if (verdict.reason == Refusal::count && record.dropped && !is_replaced(record, by))
    verdict.reason = Refusal::live_head;
  return verdict;
}

bool Fetcher::is_replaced(const Record& record, const std::optional<SignedHead>& by) const {
  return by && keeping_ && keeping_(record.kind) != Keeping::always && notary_.vouches(record, *by);
}

// Never true.
bool Fetcher::spoilt(Instant now, const RecordId& id, Fetch& fetch, Refusal reason) {
  counters_.refuse(reason);
  spoilt_.push_back({id, reason, fetch.from});
  if (reason == Refusal::forked) {
    const LogId log = id.log;
    notary_.bar(log);
    abandon([&](const LogId& other) { return other == log; });
    return false;
  }
  fetch.whole = false;
  fetch.head.reset();
  release(id, fetch);
  fetch.assembly.begin(1);
  note_need(id, fetch);
  distrust(now, fetch);
  return false;
}

void Fetcher::store_in_order(Instant now, const LogId& log) {
  blocked_.erase(log);
  for (auto at = fetches_.find({log, held(log)}); at != fetches_.end() && at->second.complete();
       at = fetches_.find({log, held(log)})) {
    if (refused(log)) return;
    Fetch& fetch = at->second;
    Record record = record_of(at->first, fetch);
    if (!is_authors_next(now, record, fetch)) return;
    if (auto kept = store(std::move(record), fetch.verdict->hash, fetch.hops); !kept) {
      counters_.refuse(Refusal::store_refused);
      blocked_[log] = {now + kStoreRetry, kept.error().text()};
      return;
    }
    used_bytes_ -= fetch.reserved_bytes;
    fetches_.erase(at);
  }
}

// Its parts stay until the store has it: it may refuse.
Record Fetcher::record_of(const RecordId& id, const Fetch& fetch) {
  Record record;
  record.id = id;
  if (fetch.head) {
    const RecordHead& head = fetch.head->record;
    record.kind = head.kind;
    record.seal = {head.previous, head.replaces, fetch.head->signature};
    record.dropped = DroppedBody{head.bytes, head.body};
  } else {
    record.kind = fetch.assembly.kind();
    wire::take_apart(fetch.assembly.body(), record);
  }
  return record;
}

Status Fetcher::store(Record record, const Hash& hash, std::uint8_t hops) {
  const RecordId id = record.id;
  const Hash previous = record.seal.previous;
  if (auto kept = store_.append(std::move(record)); !kept) return kept;
  here_.took(id);
  notary_.took(id, previous, hash);
  ++counters_.records_received;
  stored_.push_back({id, hops});
  return success();
}

const Fetcher::AllStored& Fetcher::take_stored() {
  stored_taken_.clear();
  stored_taken_.swap(stored_);
  return stored_taken_;
}

const Fetcher::AllSpoilt& Fetcher::take_spoilt() {
  spoilt_taken_.clear();
  spoilt_taken_.swap(spoilt_);
  return spoilt_taken_;
}

namespace {
bool says_that_it_replaces(const RecordHead& later, const Record& record) {
  return later.id.log == record.id.log && later.id.seq > record.id.seq && later.kind == record.kind &&
         later.replaces == record.id.seq;
}
}  // namespace

Refusal Fetcher::take(Instant now, Record record, std::optional<SignedHead> by) {
  const RecordId id = record.id;
  if (by && !says_that_it_replaces(by->head, record)) by.reset();
  Notary::Verdict verdict{judge_(id.log), {}};
  if (verdict.reason == Refusal::count) verdict = verdict_of(record, by);
  Refusal reason = verdict.reason;
  if (reason == Refusal::count && !store(std::move(record), verdict.hash, 0)) reason = Refusal::store_refused;
  if (reason != Refusal::count) {
    counters_.refuse(reason);
    return reason;
  }
  if (fetches_.contains(id)) close(id);  // nobody need send it any more
  store_in_order(now, id.log);
  return Refusal::count;
}

// What was welcome when it was asked for may not be any more.
bool Fetcher::refused(const LogId& log) {
  const Refusal verdict = judge_(log);
  if (verdict == Refusal::count) return false;
  counters_.refuse(verdict);
  abandon([&](const LogId& other) { return other == log; });
  return true;
}

}  // namespace onemap::comms
