#include "fetcher.hpp"

#include <algorithm>
#include <limits>

namespace onemap::comms {

using std::chrono::milliseconds;
using wire::kFragmentBytes;

namespace {
constexpr std::uint8_t kFirstBulkLane = 2;
constexpr std::size_t kMaxFetches = 512;
constexpr std::uint32_t kLookahead = 256;  // records of one log beyond its first missing one
constexpr std::uint32_t kMaxGuess = 64;
constexpr auto kWantDelay = milliseconds(2);  // bulk asks wait so long for company
constexpr auto kStoreRetry = milliseconds(1000);
constexpr auto kAvoid = milliseconds(1000);
}  // namespace

Fetcher::Fetcher(Limits limits, LogStore& store, Counters& counters, Judge judge)
    : limits_(limits), store_(store), counters_(counters), judge_(std::move(judge)) {
  // Room for the largest record, or it would never arrive.
  limits_.reassembly_bytes = std::max(limits_.reassembly_bytes, kMaxRecordBytes + 2 * kMaxGuess * kFragmentBytes);
}

// Control and poses may ask a quarter more, so that they never wait for bulk to drain.
std::size_t Fetcher::window(std::uint8_t lane) const {
  const std::size_t whole = std::max(limits_.credit_bytes, 4 * kFragmentBytes);
  return lane < kFirstBulkLane ? whole + whole / 4 : whole;
}

std::uint32_t Fetcher::held(const LogId& log) const {
  const auto at = store_.frontier().find(log);
  return at == store_.frontier().end() ? 0 : at->second;
}

// The most that a living neighbour holds of it.
std::uint32_t Fetcher::offer(const LogId& log, const Links& links) const {
  std::uint32_t most = 0;
  for (const auto& [endpoint, link] : links) {
    const auto at = link.holds.find(log);
    if (link.alive && at != link.holds.end()) most = std::max(most, at->second);
  }
  return most;
}

std::vector<std::pair<LogId, std::uint32_t>> Fetcher::missing(const Links& links) const {
  std::vector<std::pair<LogId, std::uint32_t>> all;
  for (const auto& lane : lacking_)
    for (const auto& [log, next] : lane) {
      const std::uint32_t have = held(log), there = offer(log, links);
      if (there > have) all.emplace_back(log, there - have);
    }
  return all;
}

std::string Fetcher::store_full() const { return blocked_.empty() ? std::string() : blocked_.begin()->second.why; }

void Fetcher::offered(const LogId& log) { lacking_[log.lane].try_emplace(log, held(log)); }

// Keeps needs_ equal to the fetches with missing fragments; called wherever `missing` changes.
void Fetcher::note_need(const RecordId& id, const Fetch& fetch) {
  if (fetch.missing > 0)
    needs_[id.log.lane].insert(id);
  else
    needs_[id.log.lane].erase(id);
}

// ---- asking

void Fetcher::plan(Instant now, Links& links) {
  no_room_for_ = std::numeric_limits<std::size_t>::max();
  for (auto& [endpoint, link] : links) {
    const std::size_t out = link.outstanding() * kFragmentBytes;
    link.may_ask_bulk = out <= window(kFirstBulkLane) / 4 * 3;
  }
  for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) {
    ask_missing(now, lane, links);
    open_more(now, lane, links);
  }
}

void Fetcher::ask_missing(Instant now, std::uint8_t lane, Links& links) {
  for (auto it = needs_[lane].begin(); it != needs_[lane].end();) {
    const RecordId id = *it++;  // asking for all of it takes it out of the set
    Fetch& fetch = fetches_.find(id)->second;
    if (fetch.not_before > now) continue;
    if (fetch.target == nullptr) fetch.target = choose(now, id, links);
    if (fetch.target != nullptr) ask(now, *fetch.target, id, fetch);
  }
}

void Fetcher::open_more(Instant now, std::uint8_t lane, Links& links) {
  for (auto it = lacking_[lane].begin(); it != lacking_[lane].end();) {
    const LogId log = it->first;
    const std::uint32_t have = held(log), offered = offer(log, links);
    if (offered <= have) {
      it = lacking_[lane].erase(it);
      continue;
    }
    std::uint32_t& next = it->second;
    next = std::max(next, have);
    if (!blocked_.contains(log))
      while (next < std::min(offered, have + kLookahead) && open(now, {log, next}, links)) ++next;
    ++it;
  }
}

bool Fetcher::open(Instant now, const RecordId& id, Links& links) {
  if (fetches_.contains(id)) return true;
  const bool first_of_log = id.seq == held(id.log);
  if (!first_of_log && fetches_.size() >= kMaxFetches) return false;
  const auto size = sizes_.find(id);
  const std::size_t guess = size == sizes_.end() ? guess_[id.log.lane] : wire::fragments_of(size->second);
  Link* link = choose(now, id, links);
  if (link == nullptr || (link->outstanding() + 1) * kFragmentBytes > window(id.log.lane)) return false;
  if (id.log.lane >= kFirstBulkLane && !link->may_ask_bulk) return false;
  if (!make_room(id, guess * kFragmentBytes)) return false;
  sizes_.erase(id);
  Fetch& fetch = fetches_[id];
  fetch.target = link;
  fetch.fragments.assign(guess, kMissing);
  fetch.missing = static_cast<std::uint32_t>(guess);
  fetch.reserved_bytes = guess * kFragmentBytes;
  used_bytes_ += fetch.reserved_bytes;
  note_need(id, fetch);
  ask(now, *link, id, fetch);
  return true;
}

// The neighbour that should answer soonest: least waiting there already, stretched by its loss.
Link* Fetcher::choose(Instant now, const RecordId& id, Links& links, const Link* other_than) const {
  Link* best = nullptr;
  double best_cost = 0.0;
  for (auto& [endpoint, link] : links) {
    if (!link.alive || &link == other_than) continue;
    const auto at = link.holds.find(id.log);
    if (at == link.holds.end() || at->second <= id.seq) continue;
    double cost = static_cast<double>(link.outstanding() + 1) / (1.0 - std::min(link.window.loss(), 0.9));
    if (link.avoid_until > now) cost += 1e6;
    if (best == nullptr || cost < best_cost) best = &link, best_cost = cost;
  }
  return best;
}

void Fetcher::ask(Instant now, Link& link, const RecordId& id, Fetch& fetch) {
  const std::uint8_t lane = id.log.lane;
  if (lane >= kFirstBulkLane && !link.may_ask_bulk) return;
  const std::size_t limit = window(lane) / kFragmentBytes;
  const std::size_t out = link.outstanding();
  std::size_t room = limit > out ? limit - out : 0;
  const auto count = static_cast<std::uint32_t>(fetch.fragments.size());
  for (std::uint32_t first = 0; first < count && room > 0 && fetch.missing > 0; ++first) {
    if (fetch.fragments[first] != kMissing) continue;
    std::uint32_t end = first + 1;
    while (end < count && fetch.fragments[end] == kMissing && end - first < room) ++end;
    ask_run(now, link, id, fetch, first, end);
    room -= end - first;
    first = end - 1;
  }
  note_need(id, fetch);
}

void Fetcher::ask_run(Instant now, Link& link, const RecordId& id, Fetch& fetch, std::uint32_t first,
                      std::uint32_t end) {
  AskLane& lane = link.lanes[id.log.lane];
  const bool idle = link.outstanding() == 0;
  if (lane.outstanding == 0) lane.progress = now;
  for (std::uint32_t fragment = first; fragment < end; ++fragment) {
    fetch.fragments[fragment] = next_serial_;
    lane.asks.push_back({id, fragment, next_serial_, false, 0, std::nullopt});
    if (++next_serial_ == kReceived) next_serial_ = 1;
  }
  lane.outstanding += end - first;
  fetch.missing -= end - first;
  link.wants.push_back({id, static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(end - first)});
  const Instant at = idle || id.log.lane < kFirstBulkLane ? now : now + kWantDelay;
  link.want_at = link.want_at ? std::min(*link.want_at, at) : at;
}

// ---- answers

void Fetcher::on_data(Instant now, Link& from, const wire::Data& data) {
  no_room_for_ = std::numeric_limits<std::size_t>::max();
  const auto at = fetches_.find(data.id);
  if (at == fetches_.end() || at->second.complete) {
    counters_.refuse(Refusal::data_unasked);
    counters_.duplicate_body_bytes += data.bytes.size();
    return;
  }
  Fetch& fetch = at->second;
  if (const Refusal refused = judge_(data.id.log); refused != Refusal::count) {
    counters_.refuse(refused);
    return abandon([&](const LogId& log) { return log == data.id.log; });
  }
  if (!learn(from, data, fetch)) return;
  std::uint32_t& state = fetch.fragments[data.fragment];
  if (state != kMissing && state != kReceived && fetch.target != nullptr) {
    answered(now, *fetch.target, data.id, state);
  } else {
    from.round_trip.was_hasty();
  }
  if (state == kReceived) {
    counters_.duplicate_body_bytes += data.bytes.size();
    return;
  }
  if (state == kMissing) {
    --fetch.missing;
    note_need(data.id, fetch);
  }
  state = kReceived;
  std::copy(data.bytes.begin(), data.bytes.end(),
            fetch.body.begin() + static_cast<std::ptrdiff_t>(data.fragment * kFragmentBytes));
  counters_.body_bytes_received += data.bytes.size();
  fetch.hops = std::max<std::uint8_t>(fetch.hops, static_cast<std::uint8_t>(std::min(data.hops + 1, 255)));
  for (std::uint8_t lane = data.id.log.lane; lane < kLaneCount; ++lane) from.lanes[lane].progress = now;
  from.silences = 0;
  if (++fetch.received == fetch.fragments.size()) settle(now, from, data.id, fetch);
}

// The first fragment says how large the record is; the others must agree with it.
bool Fetcher::learn(Link& from, const wire::Data& data, Fetch& fetch) {
  if (fetch.known) {
    if (fetch.kind == data.kind && fetch.total_bytes == data.total_bytes && fetch.hash == data.body_hash) return true;
    counters_.refuse(Refusal::data_conflict);
    if (&from != fetch.target) return false;
    restart(data.id, fetch);  // whom we ask now counts more than whom we asked before
  }
  if (!reserve(data.id, fetch, data.total_bytes)) return false;
  const std::uint32_t count = wire::fragments_of(data.total_bytes);
  cut(data.id, fetch, count);
  fetch.known = true;
  fetch.kind = data.kind;
  fetch.total_bytes = data.total_bytes;
  fetch.hash = data.body_hash;
  fetch.fragments.resize(count, kMissing);
  fetch.missing = static_cast<std::uint32_t>(std::count(fetch.fragments.begin(), fetch.fragments.end(), kMissing));
  note_need(data.id, fetch);
  fetch.body.resize(data.total_bytes);
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
    const bool known = it->second.known;
    const std::uint32_t size = it->second.total_bytes;
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

// Later asks that are answered make earlier ones suspect: the neighbour serves a lane in order.
void Fetcher::answered(Instant now, Link& target, const RecordId& id, std::uint32_t serial) {
  AskLane& lane = target.lanes[id.log.lane];
  constexpr std::uint8_t kOvertakenBy = 3;
  for (Ask& ask : lane.asks) {
    if (ask.serial == serial) {
      if (!ask.done) --lane.outstanding;
      ask.done = true;
      break;
    }
    if (ask.done || ask.overtaken == kOvertakenBy || ++ask.overtaken < kOvertakenBy) continue;
    ask.overtaken_at = now;
    if (!lane.suspect_since) lane.suspect_since = now;
  }
  trim(lane);
}

void Fetcher::settle(Instant now, Link& from, const RecordId& id, Fetch& fetch) {
  if (wire::body_hash(fetch.kind, fetch.body) != fetch.hash) {
    counters_.refuse(Refusal::data_bad_hash);
    restart(id, fetch);
    fetch.target = nullptr;
    from.avoid_until = now + kAvoid;
    // Bad luck once; who spoils it again and again is not worth the bandwidth.
    if (++fetch.bad_bodies > 1) fetch.not_before = now + kAvoid * (1u << std::min(fetch.bad_bodies - 2, 6u));
    wake_ = std::min(wake_, std::max(fetch.not_before, now));
    return;
  }
  fetch.complete = true;
  store_in_order(now, id.log);
}

void Fetcher::store_in_order(Instant now, const LogId& log) {
  blocked_.erase(log);
  for (auto at = fetches_.find({log, held(log)}); at != fetches_.end() && at->second.complete;
       at = fetches_.find({log, held(log)})) {
    const RecordId id = at->first;
    Fetch& fetch = at->second;
    if (const Refusal refused = judge_(log); refused != Refusal::count) {
      counters_.refuse(refused);
      return abandon([&](const LogId& other) { return other == log; });
    }
    // The body is copied only when the store may refuse it: then it must survive for the next try.
    if (auto kept = store_.append({id, fetch.kind, fetch.body}); !kept) {
      counters_.refuse(Refusal::store_refused);
      blocked_[log] = {now + kStoreRetry, kept.error().text()};
      return;
    }
    ++counters_.records_received;
    stored_.push_back({id, fetch.hops});
    used_bytes_ -= fetch.reserved_bytes;
    fetches_.erase(at);
  }
}

}  // namespace onemap::comms
