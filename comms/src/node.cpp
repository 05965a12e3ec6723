#include "comms/node.hpp"

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
constexpr auto kSeekInterval = std::chrono::milliseconds(700);

std::uint64_t seed_of(const RobotId& robot, std::uint64_t incarnation) {
  std::uint64_t seed = incarnation;
  for (auto byte : robot.bytes) seed = seed * 31 + byte;
  return seed;
}
}  // namespace

RateBounds rate_bounds(const NodeConfig& config) {
  RateBounds bounds;
  bounds.least = static_cast<double>(std::max<std::uint64_t>(config.link_least_bytes_per_second, 1'000));
  bounds.most = std::max(bounds.least, static_cast<double>(config.link_most_bytes_per_second));
  return bounds;
}

Node::Impl::Impl(NodeConfig config_, LogStore& store_)
    : config(std::move(config_)),
      memory(config.memory_bytes, config.memory_at_once),
      store(store_),
      fetcher(
          {config.credit_bytes, config.most_credit_bytes, config.reassembly_bytes}, store, held_logs, notary, counters,
          [this](const LogId& log) { return judge(log); }, config.keeping, memory),
      team(config.self, config.incarnation, config.max_robots, config.max_neighbours, memory),
      talks(config.self, config.incarnation, memory),
      replacements(config.keeping, memory),
      trickle(config.beacon_min, config.beacon_max),
      seeking(config.beacon_min, std::min<Duration>(config.beacon_max, kSeekInterval)),
      random(seed_of(config.self, config.incarnation)),
      pacer(config.bytes_per_second, config.train_datagrams) {
  assert(wire::is_life(config.incarnation) && config.self.valid());
  for (const Endpoint& endpoint : config.peers) {
    Peer& peer = place(endpoint);
    peer.configured = true;
    prepare(peer);
  }
  if (config.identity) notary.pin(config.self, config.identity->public_key());
  notary.start(store);
  held_logs.start(store.frontier());
  for (const auto& [log, count] : store.frontier()) take_held(log, count);
  team.set_own(frontier_digest, 0, 0);
  if (!undurable.empty()) settle_own();
}

// Of what the store holds at the start all may hear, but for own records that the disk has not promised to keep yet.
void Node::Impl::take_held(const LogId& log, std::uint32_t count) {
  const std::uint32_t may_hear = log.robot == config.self ? std::min(count, store.durable(log)) : count;
  for (std::uint32_t seq = may_hear; seq < count; ++seq) undurable.push_back({log, seq});
  if (may_hear == 0) return;
  applied.push(log, 0, may_hear);
  hops[log].assign(may_hear, 0);
  team.recorded(log, true, now);
  frontier_digest += entry_digest(log, may_hear);
}

Peer& Node::Impl::place(const Endpoint& endpoint) {
  Peer& peer = peers.try_emplace(endpoint, memory).first->second;
  peer.endpoint = endpoint;
  return peer;
}

// Of a new endpoint.
void Node::Impl::prepare(Peer& peer) {
  peer.rate = RateController(rate_bounds(config), memory);
  peer.budget = LinkBudget(config.link_budget_bytes_per_second, config.link_budget_bytes_per_day);
}

std::uint32_t Node::Impl::held(const LogId& log) const { return held_logs.count(log); }

void Node::Impl::advance(Instant to) {
  if (now == Instant{}) team.start(to);
  now = std::max(now, to);
}

Refusal Node::Impl::judge(const LogId& log) const {
  if (!wire::is_life(log.incarnation)) return Refusal::bad_incarnation;
  if (notary.barred(log)) return Refusal::forked;
  if (log.robot == config.self && log.incarnation > config.incarnation) return Refusal::later_life;
  const Peer* author = living(log.robot);
  // Who greets in an earlier life than one whose records are here is no author any more: it would be refused now.
  const bool counts =
      author != nullptr && !author->who.doubtful && author->who.incarnation >= team.life_in_records(log.robot);
  if (counts && log.incarnation > author->who.incarnation) return Refusal::contradicts_author;
  if (held(log) > 0) return Refusal::count;
  if (store.frontier().size() >= config.max_logs) return Refusal::logs_full;
  if (!team.room_for(log.robot, author != nullptr)) return Refusal::robots_full;
  const bool own_word = author != nullptr && log.incarnation == author->who.incarnation;
  if (!own_word && team.logs_of(log.robot) >= config.max_logs_of_robot) return Refusal::robot_logs_full;
  return Refusal::count;
}

Result<RecordId> Node::Impl::append(std::uint8_t lane, std::uint16_t kind, std::vector<std::uint8_t> body,
                                    std::uint32_t replaces) {
  const LogId log{config.self, lane, config.incarnation};
  const RecordId id{log, held(log)};
  const auto refused = [this](std::string why) {
    refuse(Refusal::append_refused);
    return Error{"own record", std::move(why)};
  };
  if (lane >= kLaneCount)
    return refused("lane " + std::to_string(lane) + " is unknown; lanes are 0 to " + std::to_string(kLaneCount - 1));
  if (body.size() > kMaxRecordBytes)
    return refused("its body has " + std::to_string(body.size()) + " bytes; a record holds at most " +
                   std::to_string(kMaxRecordBytes));
  if (!config.identity) return refused("this robot has no key to sign it with");
  Record record{id, kind, std::move(body), {}, {}};
  const bool of_its_own = replacements.keeping(kind) == Keeping::until_the_next;
  record.seal.replaces = of_its_own ? replacements.before(log, kind) : replaces;
  const Hash hash = notary.seal_next(record, *config.identity), previous = record.seal.previous;
  if (auto kept = store.append(std::move(record)); !kept) return refused(kept.error().text());
  held_logs.took(id);
  notary.took(id, previous, hash);
  replacements.wrote(id, kind);
  ++counters.records_appended;
  undurable.push_back(id);  // durable before anybody hears of it
  settle_own();
  return id;
}

void Node::Impl::settle_own() {
  const Status synced = store.sync();
  sync_error = synced ? std::string() : synced.error().text();
  // In order within each log; a log whose records are durable does not wait for another's.
  for (auto it = undurable.begin(); it != undurable.end();) {
    if (store.durable(it->log) > it->seq) {
      stored(*it, 0);
      it = undurable.erase(it);
    } else {
      ++it;
    }
  }
}

std::uint32_t Node::Impl::told(const LogId& log) const {
  const auto* const known = hops.find(log);
  return known == nullptr ? 0 : static_cast<std::uint32_t>(known->size());
}

void Node::Impl::stored(const RecordId& id, std::uint8_t hop_count) {
  constexpr auto kHaveGap = std::chrono::milliseconds(5);
  // Who has it from somebody else is in no hurry to hear that it is here, too. Who gets it pushed may not get it, and
  // an author may wait for the news.
  constexpr auto kSoon = std::chrono::milliseconds(50), kIdle = std::chrono::milliseconds(300);
  applied.push(id.log, id.seq, id.seq + 1);
  append_snugly(hops[id.log], hop_count);
  team.recorded(id.log, id.seq == 0, now);
  frontier_digest += entry_digest(id.log, id.seq + 1) - entry_digest(id.log, id.seq);
  push(id);
  for (auto& [endpoint, peer] : peers) {
    if (!peer.who.alive) continue;
    const bool lacks_it = peer.frontier.count(id.log) <= id.seq && !peer.push.holds(id);
    const bool soon = id.log.robot == config.self || id.log.robot == peer.who.robot;
    const Instant idle = now + (soon ? kSoon : kIdle);
    peer.outbox.tell(id.log, lacks_it ? std::max(now, peer.outbox.last_have() + kHaveGap) : idle, lacks_it);
  }
  const RobotStatus& own = team.own();
  team.set_own(frontier_digest, own.map_digest, own.flags);
  changed();
}

// Whoever is told of it later will mostly have it by then.
void Node::Impl::push(const RecordId& id) {
  if (id.log.robot != config.self || id.log.incarnation != config.incarnation || id.log.lane > wire::kLastPushedLane)
    return;
  const auto record = store.find(id);
  if (record == nullptr || record->dropped || wire::fragments_of(wire::payload_bytes(*record)) != 1) return;
  const auto payload = wire::fragment_of(*record, 0, fragment_scratch);
  const auto whole = std::allocate_shared<const PushQueue::Whole>(
      std::pmr::polymorphic_allocator<PushQueue::Whole>(&memory),
      PushQueue::Whole{id, record->kind, hashes.of(*record), {payload.begin(), payload.end(), &memory}});
  for (auto& [endpoint, peer] : peers)
    if (peer.who.alive) peer.push.push(whole, now, std::max(peer.rate.loss(), peer.session.loss()));
}

std::optional<std::uint8_t> Node::Impl::hops_of(const RecordId& id) const {
  const auto* const log = hops.find(id.log);
  if (log == nullptr || id.seq >= log->size()) return std::nullopt;
  return (*log)[id.seq];
}

Node::Node(NodeConfig config, LogStore& store) : impl_(std::make_unique<Impl>(std::move(config), store)) {}
Node::~Node() = default;

void Node::on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes) {
  impl_->advance(now);
  impl_->receive(from, bytes);
}

void Node::on_timer(Instant now) {
  impl_->advance(now);
  impl_->tick();
}

Instant Node::next_deadline() const { return impl_->next_deadline(); }

Result<RecordId> Node::append(Instant now, std::uint8_t lane, std::uint16_t kind, std::vector<std::uint8_t> body,
                              std::uint32_t replaces) {
  impl_->advance(now);
  return impl_->append(lane, kind, std::move(body), replaces);
}

Refusal Node::take(Instant now, Record record, std::optional<SignedHead> by) {
  impl_->advance(now);
  return impl_->take(std::move(record), by);
}

bool Node::let_go(const RecordId& id) {
  return impl_->replacements.instead_of(id).has_value() && impl_->store.forget(id);
}

void Node::set_local_status(Instant now, std::uint64_t map_digest, std::uint8_t flags) {
  impl_->advance(now);
  if (impl_->team.set_own(impl_->frontier_digest, map_digest, flags)) impl_->changed();
}

void Node::bring(Instant now, Scalar which, double own) {
  impl_->advance(now);
  impl_->talks.bring(now, which, own);
}

ScalarsView Node::scalars() const { return impl_->talks.view(); }

bool Node::next_outgoing(OutgoingDatagram& datagram) { return impl_->next_outgoing(datagram); }

bool Node::next_applied(std::shared_ptr<const Record>& record) {
  while (const auto id = impl_->applied.pop()) {
    record = impl_->store.find(*id);
    if (record != nullptr) {
      if (const auto replaced = impl_->replacements.took(*record)) impl_->store.forget(*replaced);
      return true;
    }
    impl_->refuse(Refusal::unreadable);
  }
  return false;
}

std::optional<Complaint> Node::next_complaint() {
  if (impl_->complaints.empty()) return std::nullopt;
  const Complaint complaint = impl_->complaints.front();
  impl_->complaints.pop_front();
  return complaint;
}

std::pmr::memory_resource& Node::memory() { return impl_->memory; }

MemoryView Node::memory_view() const {
  const Arena& memory = impl_->memory;
  return {memory.capacity(), memory.used(), memory.most_used(), memory.spilled()};
}

bool Node::pin(const RobotId& robot, const PublicKey& key) { return impl_->notary.pin(robot, key); }
std::optional<PublicKey> Node::key_of(const RobotId& robot) const { return impl_->notary.key_of(robot); }

const VersionVector& Node::frontier() const { return impl_->store.frontier(); }
std::uint64_t Node::frontier_digest() const { return impl_->frontier_digest; }

std::vector<NeighbourStatus> Node::neighbours() const {
  std::vector<NeighbourStatus> all;
  for (const auto& [endpoint, peer] : impl_->peers) {
    if (peer.who.incarnation == 0) continue;
    all.push_back({peer.who.robot,
                   peer.who.incarnation,
                   endpoint,
                   peer.who.alive,
                   peer.who.last_heard,
                   peer.session.loss(),
                   peer.round_trip.smoothed(),
                   peer.bytes_in,
                   peer.bytes_out,
                   peer.rate.bytes_per_second(),
                   peer.rate.queue(),
                   std::max(peer.rate.loss(), peer.word.loss_there.value_or(0.0)),
                   peer.asks.outstanding() * wire::kFragmentBytes,
                   peer.serve.queued_bytes(),
                   peer.frontier.claimed_digest(),
                   peer.word.map_digest,
                   peer.word.flags,
                   peer.traffic,
                   peer.budget.allows(impl_->now),
                   peer.budget.spent_today(impl_->now)});
  }
  return all;
}

const std::pmr::map<RobotId, RobotStatus>& Node::team() const { return impl_->team.robots(); }

bool Node::team_agrees(std::uint8_t flags, const std::set<RobotId>& without) const {
  const RobotStatus& own = impl_->team.own();
  const auto agrees = [&](const auto& entry) {
    const RobotStatus& status = entry.second;
    if (without.contains(entry.first)) return true;
    return (status.flags & flags) == flags && status.map_digest == own.map_digest &&
           status.frontier_digest == own.frontier_digest;
  };
  return std::all_of(team().begin(), team().end(), agrees);
}

std::size_t Node::records_missing() const {
  std::size_t missing = 0;
  for (const auto& [log, count] : impl_->fetcher.missing(impl_->peers)) missing += count;
  return missing;
}

std::set<RobotId> Node::incomplete() const {
  std::set<RobotId> robots;
  for (const auto& [log, count] : impl_->fetcher.missing(impl_->peers))
    if (log.robot != impl_->config.self) robots.insert(log.robot);
  return robots;
}

std::string Node::store_full() const {
  return impl_->sync_error.empty() ? impl_->fetcher.store_full() : impl_->sync_error;
}

std::optional<std::uint8_t> Node::hops(const RecordId& id) const { return impl_->hops_of(id); }

std::map<RobotId, Presence> Node::presence(Instant now) const {
  std::map<RobotId, Presence> out;
  for (const auto& [id, status] : team())
    out[id] = {status.incarnation, impl_->team.last_sign(id), false, status.flags};
  for (const auto& [endpoint, peer] : impl_->peers) {
    const auto at = out.find(peer.who.robot);
    if (!peer.who.alive || at == out.end()) continue;
    at->second.neighbour = true;
    at->second.last_sign = std::max(at->second.last_sign, peer.who.last_heard);
  }
  out[impl_->config.self].last_sign = now;
  return out;
}

bool Node::is_configured(const Endpoint& at) const {
  const auto peer = impl_->peers.find(at);
  return peer != impl_->peers.end() && peer->second.configured;
}

std::vector<Endpoint> Node::peers_never_heard() const {
  std::vector<Endpoint> out;
  for (const auto& [endpoint, peer] : impl_->peers)
    if (peer.configured && !peer.ever_heard) out.push_back(endpoint);
  return out;
}

std::optional<IdConflict> Node::id_conflict() const { return impl_->conflict; }
std::optional<std::uint64_t> Node::outlived() const { return impl_->outlived; }

std::uint32_t Node::held_by(const RobotId& neighbour, const LogId& log) const {
  const Peer* peer = impl_->living(neighbour);
  return peer == nullptr ? 0 : peer->frontier.count(log);
}

bool Node::delivered(std::uint8_t up_to_lane) const {
  for (const auto& [endpoint, peer] : impl_->peers) {
    if (!peer.who.alive) continue;
    for (std::uint8_t lane = 0; lane <= up_to_lane; ++lane) {
      const LogId log{impl_->config.self, lane, impl_->config.incarnation};
      if (impl_->held(log) > peer.frontier.count(log)) return false;
    }
  }
  return true;
}

bool Node::own_settled() const { return impl_->undurable.empty(); }

const Counters& Node::counters() const { return impl_->counters; }

}  // namespace onemap::comms
