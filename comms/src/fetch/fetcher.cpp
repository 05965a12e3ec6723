#include "fetch/fetcher.hpp"

#include <algorithm>
#include <limits>

#include "comms/store_share.hpp"

namespace onemap::comms {

using std::chrono::milliseconds;
using wire::kFragmentBytes;

namespace {
constexpr std::size_t kMaxFetches = 512;
constexpr std::uint32_t kLookahead = 256;  // records of one log beyond its first missing one
constexpr Duration kServerQueue = milliseconds(60);
constexpr auto kWantDelay = milliseconds(2);  // bulk asks wait so long for company
}  // namespace

Fetcher::Fetcher(Limits limits, LogStore& store, HeldLogs& here, Notary& notary, Counters& counters, Judge judge,
                 KeepingOf keeping, Memory& memory)
    : memory_(&memory),
      limits_(limits),
      store_(store),
      here_(here),
      notary_(notary),
      counters_(counters),
      judge_(std::move(judge)),
      keeping_(std::move(keeping)),
      fetches_(&memory),
      needs_(of_each_lane<std::pmr::set<RecordId>>(memory)),
      lacking_(of_each_lane<std::pmr::map<LogId, std::uint32_t>>(memory)),
      blocked_(&memory),
      sizes_(&memory),
      stored_(&memory),
      stored_taken_(&memory),
      spoilt_(&memory),
      spoilt_taken_(&memory) {
  // Room for the largest record, or it would never arrive.
  limits_.reassembly_bytes =
      std::max(limits_.reassembly_bytes, wire::kMaxPayloadBytes + 2 * kMaxGuess * kFragmentBytes);
}

// Twice what comes in a round trip and while as much waits at the server as keeps it busy when some asks are lost; and
// more when many are: what is lost, on the way there or back, counts until that is noticed. Control and poses may ask a
// quarter more, so that they never wait for bulk to drain.
std::size_t Fetcher::window(const Peer& peer, std::uint8_t lane) const {
  const double arrive = 1.0 - std::min(peer.session.loss(), 0.5);
  const double flow = 2.0 * peer.arrivals.bytes_per_second() / (arrive * arrive) *
                      to_seconds(peer.round_trip.smoothed() + kServerQueue);
  const std::size_t whole = std::max(
      {4 * kFragmentBytes, limits_.credit_bytes, std::min(limits_.most_credit_bytes, static_cast<std::size_t>(flow))});
  return lane < kFirstBulkLane ? whole + whole / 4 : whole;
}

std::uint32_t Fetcher::held(const LogId& log) const { return here_.count(log); }

std::uint32_t Fetcher::offer(const LogId& log, const Peers& peers) const {
  std::uint32_t most = 0;
  for (const auto& [endpoint, peer] : peers)
    if (peer.who.alive) most = std::max(most, peer.frontier.count(log));
  return most;
}

std::vector<std::pair<LogId, std::uint32_t>> Fetcher::missing(const Peers& peers) const {
  std::vector<std::pair<LogId, std::uint32_t>> all;
  for (const auto& lane : lacking_)
    for (const auto& [log, next] : lane) {
      const std::uint32_t have = held(log), there = offer(log, peers);
      if (there > have) all.emplace_back(log, there - have);
    }
  return all;
}

std::string Fetcher::store_full() const { return blocked_.empty() ? std::string() : blocked_.begin()->second.why; }

void Fetcher::offered(const LogId& log) {
  lacking_[log.lane].try_emplace(log, held(log));
  offered_ = true;
}

// Keeps needs_ equal to the fetches with missing fragments; called wherever `missing` changes.
void Fetcher::note_need(const RecordId& id, const Fetch& fetch) {
  if (fetch.assembly.missing() > 0)
    needs_[id.log.lane].insert(id);
  else
    needs_[id.log.lane].erase(id);
}

void Fetcher::plan(Instant now, Peers& peers) {
  no_room_for_ = std::numeric_limits<std::size_t>::max();
  if (std::exchange(offered_, false)) leave_the_silent(now, peers);
  bool any = false, any_bulk = false;  // somebody may be asked
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive) continue;
    const std::size_t out = peer.asks.outstanding() * kFragmentBytes;
    peer.asks.may_ask_bulk = out <= window(peer, kFirstBulkLane) / 8 * 7 && peer.budget.allows(now);
    any_bulk |= peer.asks.may_ask_bulk;
    any |= out + kFragmentBytes <= window(peer, 0);
  }
  for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) {
    if (lane < kFirstBulkLane ? !any : !any_bulk) continue;
    ask_missing(now, lane, peers);
    open_more(now, lane, peers);
  }
}

void Fetcher::ask_missing(Instant now, std::uint8_t lane, Peers& peers) {
  for (auto it = needs_[lane].begin(); it != needs_[lane].end();) {
    const RecordId id = *it++;  // asking for all of it takes it out of the set
    Fetch& fetch = fetches_.find(id)->second;
    if (fetch.not_before > now) continue;
    if (fetch.target == nullptr) fetch.target = choose(now, id, peers);
    if (fetch.target != nullptr) ask(now, *fetch.target, id, fetch);
  }
}

void Fetcher::open_more(Instant now, std::uint8_t lane, Peers& peers) {
  for (auto it = lacking_[lane].begin(); it != lacking_[lane].end();) {
    const LogId log = it->first;
    const std::uint32_t have = held(log), offered = offer(log, peers);
    if (offered <= have) {
      it = lacking_[lane].erase(it);
      continue;
    }
    std::uint32_t& next = it->second;
    next = std::max(next, have);
    if (!blocked_.contains(log))
      while (next < std::min(offered, have + kLookahead) && open(now, {log, next}, peers)) ++next;
    ++it;
  }
}

bool Fetcher::open(Instant now, const RecordId& id, Peers& peers) {
  if (fetches_.contains(id)) return true;
  const bool first_of_log = id.seq == held(id.log);
  if (!first_of_log && fetches_.size() >= kMaxFetches) return false;
  const auto size = sizes_.find(id);
  const std::size_t guess = size == sizes_.end() ? guess_[id.log.lane] : wire::fragments_of(size->second);
  Peer* peer = choose(now, id, peers);
  if (peer == nullptr || (peer->asks.outstanding() + 1) * kFragmentBytes > window(*peer, id.log.lane)) return false;
  if (id.log.lane >= kFirstBulkLane && !peer->asks.may_ask_bulk) return false;
  if (!make_room(id, guess * kFragmentBytes)) return false;
  sizes_.erase(id);
  Fetch& fetch = fetches_.try_emplace(id, *memory_).first->second;
  fetch.target = peer;
  fetch.assembly.begin(static_cast<std::uint32_t>(guess));
  fetch.reserved_bytes = guess * kFragmentBytes;
  used_bytes_ += fetch.reserved_bytes;
  note_need(id, fetch);
  ask(now, *peer, id, fetch);
  return true;
}

// The neighbour that should answer soonest: least waiting there already, stretched by its loss. Of those who are
// avoided the one that was silent least often.
Peer* Fetcher::choose(Instant now, const RecordId& id, Peers& peers, const Peer* other_than) const {
  Peer* best = nullptr;
  double best_cost = 0.0;
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive || &peer == other_than || peer.frontier.count(id.log) <= id.seq) continue;
    if (id.log.lane >= kFirstBulkLane && !peer.budget.allows(now)) continue;
    double cost = static_cast<double>(peer.asks.outstanding() + 1) / (1.0 - std::min(peer.session.loss(), 0.9));
    if (peer.asks.avoided(now)) cost += 1e6 * (1 + peer.asks.silences());
    if (best == nullptr || cost < best_cost) best = &peer, best_cost = cost;
  }
  return best;
}

void Fetcher::ask(Instant now, Peer& peer, const RecordId& id, Fetch& fetch) {
  const std::uint8_t lane = id.log.lane;
  if (lane >= kFirstBulkLane && !peer.asks.may_ask_bulk) return;
  const std::size_t limit = window(peer, lane) / kFragmentBytes;
  const std::size_t out = peer.asks.outstanding();
  std::size_t room = limit > out ? limit - out : 0;
  const Assembly& record = fetch.assembly;
  const std::uint32_t count = record.fragments();
  for (std::uint32_t first = 0; first < count && room > 0 && record.missing() > 0; ++first) {
    if (!record.is_missing(first)) continue;
    std::uint32_t end = first + 1;
    while (end < count && record.is_missing(end) && end - first < room) ++end;
    ask_run(now, peer, id, fetch, first, end);
    room -= end - first;
    first = end - 1;
  }
  note_need(id, fetch);
}

void Fetcher::ask_run(Instant now, Peer& peer, const RecordId& id, Fetch& fetch, std::uint32_t first,
                      std::uint32_t end) {
  const bool idle = peer.asks.outstanding() == 0;
  for (std::uint32_t fragment = first; fragment < end; ++fragment) {
    fetch.assembly.asked(fragment, next_serial_);
    peer.asks.add(now, {id, fragment}, next_serial_);
    if (++next_serial_ == Assembly::kHere) next_serial_ = Assembly::kMissing + 1;
  }
  peer.outbox.want({id, static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(end - first)},
                   idle || id.log.lane < kFirstBulkLane ? now : now + kWantDelay);
}

}  // namespace onemap::comms
