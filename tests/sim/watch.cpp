#include "sim/watch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "comms/frontier.hpp"
#include "comms/record_head.hpp"
#include "session/sealed_wire.hpp"

namespace onemap::comms::sim {

namespace {
constexpr std::size_t kMaxServeBytes = 2u << 20;  // PROTOCOL.md: whatever credit somebody gives himself
constexpr std::uint64_t kLookAtFlightsEvery = 4;
constexpr std::size_t kManyLogs = 64;
constexpr std::uint32_t kMostPushes = 4;  // of an own control or pose record

// Of what it says; the same when its body was dropped.
std::uint64_t hash_of(const Record& record) {
  const RecordHead head = head_of(record);
  return wire::body_hash(head.kind, head.body) * 0x9E3779B97F4A7C15u + entry_digest(record.id.log, record.id.seq + 1) +
         head.bytes;
}
std::string text(const RecordId& id) {
  return fmt::format("{}/{}/{} #{}", id.log.robot.name(), id.log.incarnation, id.log.lane, id.seq);
}
}  // namespace

Watch::Seen& Watch::seen(std::size_t robot) {
  if (robots_.size() <= robot) robots_.resize(robot + 1);
  return robots_[robot];
}

void Watch::broke(std::size_t robot, const std::string& what) {
  if (broken()) return;
  what_ = fmt::format("{:.6f} s, robot{}: {}", to_seconds(net_.now().time_since_epoch()), robot, what);
}

void Watch::began(std::size_t robot) {
  const std::uint64_t wiped_below = seen(robot).wiped_below;
  robots_[robot] = {};
  robots_[robot].wiped_below = wiped_below;
}

void Watch::came_back(std::size_t robot) {
  const VersionVector& here = net_[robot].store->frontier();
  for (const RecordId& id : promised_) {
    if (id.log.robot != net_[robot].config.self || id.log.incarnation < seen(robot).wiped_below) continue;
    const auto log = here.find(id.log);
    ++looks_;
    if (log == here.end() || log->second <= id.seq)
      return broke(robot, fmt::format("its own record {} was said to be kept and is not on its disk", text(id)));
  }
}

void Watch::appended(std::size_t robot, const Record& record) {
  ++looks_;
  if (!written_.emplace(record.id, hash_of(record)).second)
    broke(robot, fmt::format("sequence number used twice: {}", text(record.id)));
}

void Watch::applied(std::size_t robot, const Record& record) {
  Seen& here = seen(robot);
  ++looks_;
  std::uint32_t& next = here.next[record.id.log];
  if (record.id.seq != next)
    broke(robot, fmt::format("record {} is given out where #{} is the next", text(record.id), next));
  next = record.id.seq + 1;
  const std::uint64_t hash = hash_of(record);
  here.set_hash += hash;
  const auto own = net_[robot].node->frontier().find(record.id.log);
  if (own == net_[robot].node->frontier().end() || own->second <= record.id.seq)
    broke(robot, fmt::format("record {} is given out and not in the frontier", text(record.id)));
  const auto true_one = written_.find(record.id);
  if (true_one != written_.end() && true_one->second != hash)
    broke(robot, fmt::format("record {} is not what its author wrote", text(record.id)));
  const bool own_one = record.id.log.robot == net_[robot].config.self;
  if (own_one && true_one != written_.end()) {
    told_.insert(record.id);
    if (net_[robot].disk->works()) promised_.insert(record.id);
  } else if (true_one != written_.end() && !told_.contains(record.id)) {
    broke(robot, fmt::format("record {} is here, and its author's disk has not promised to keep it", text(record.id)));
  }
}

// What has no body was replaced by a later record of its log and kind.
void Watch::look_at_bodies(std::size_t robot) {
  const KeepingOf& keeping = net_[robot].config.keeping;
  std::set<RecordId> needless;
  std::vector<std::pair<RecordId, std::uint16_t>> dropped;
  net_[robot].store->scan([&](const auto& record) {
    ++looks_;
    const auto& [log, seq] = record->id;
    if (record->seal.replaces < seq) needless.insert({log, record->seal.replaces});
    if (record->dropped) dropped.emplace_back(record->id, record->kind);
  });
  for (const auto& [id, kind] : dropped)
    if (!needless.contains(id) || keeping(kind) == Keeping::always)
      broke(robot, fmt::format("record {} has no body, and nothing took its place", text(id)));
}

void Watch::moved(std::size_t robot) {
  if (!net_.runs(robot)) return;
  Seen& here = seen(robot);
  if (net_[robot].node->frontier_digest() != here.digest) look_at_frontier(robot, here);
  if (here.moves++ % (kLookAtFlightsEvery + net_.size() / 2) == 0) look_at_flights(robot, here);
}

void Watch::look_at_frontier(std::size_t robot, Seen& here) {
  ++looks_;
  const Node& node = *net_[robot].node;
  here.digest = node.frontier_digest();
  const auto [set, first] = sets_.emplace(here.digest, here.set_hash);
  if (!first && set->second != here.set_hash) broke(robot, "equal frontiers, and not the same records");
  if (const MemoryView memory = node.memory_view(); memory.spilled > 0)
    broke(robot,
          fmt::format("{} of {} bytes of its memory are used, and more was needed", memory.used, memory.capacity));
  // The rest takes its time.
  if (node.frontier().size() > kManyLogs && here.changes++ % kManyLogs != 0) return;
  VersionVector now = node.frontier();
  for (auto& [log, count] : now)  // what its disk has not promised to keep is not there yet
    if (log.robot == net_[robot].config.self) count = std::min(count, here.next[log]);
  std::erase_if(now, [](const auto& entry) { return entry.second == 0; });
  if (digest(now) != here.digest) broke(robot, "the digest is not that of the frontier");
  for (const auto& [log, count] : here.frontier) {
    const auto at = now.find(log);
    if (at == now.end() || at->second < count) broke(robot, "the frontier went back");
  }
  here.frontier = now;
  for (const auto& [log, count] : now)
    if (here.next[log] != count)
      return broke(robot, fmt::format("{} of {} records of {}/{} were given out", here.next[log], count,
                                      log.robot.name(), log.lane));
}

void Watch::look_at_flights(std::size_t robot, const Seen& here) {
  ++looks_;
  const NodeConfig& config = net_[robot].config;
  const std::size_t credit = std::max({config.credit_bytes, config.most_credit_bytes, 4 * wire::kFragmentBytes});
  const std::size_t most = credit + credit / 4;
  for (const NeighbourStatus& neighbour : net_[robot].node->neighbours()) {
    if (neighbour.asked_bytes > most)
      broke(robot, fmt::format("{} bytes are asked of {}, its credit is {}", neighbour.asked_bytes,
                               neighbour.robot.name(), most));
    const auto other = here.others.find(neighbour.endpoint);
    std::size_t allowed = other == here.others.end() ? 0 : std::min<std::size_t>(other->second.credit, kMaxServeBytes);
    if (config.sealed) allowed = kMaxServeBytes;  // what it asked for cannot be read
    if (neighbour.queued_bytes > allowed)
      broke(robot, fmt::format("{} bytes wait for {}, whose credit is {}", neighbour.queued_bytes,
                               neighbour.robot.name(), allowed));
  }
}

void Watch::arrives(std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes) {
  Seen& here = seen(to);
  Stranger& other = here.others[from];
  other.in += bytes.size();
  if (net_[to].config.sealed) return;
  if (decoder_.decode(bytes) != Refusal::count) return;
  const wire::Header& header = decoder_.header();
  if (header.type != wire::DatagramType::unicast || header.receiver != net_[to].config.incarnation) return;
  other.proved = true;
  note_wants(here, other, from);
}

void Watch::note_wants(Seen& here, Stranger& other, const Endpoint& from) {
  for (const wire::Frame& frame : decoder_.frames()) {
    const auto* want = std::get_if<wire::Want>(&frame);
    if (want == nullptr) continue;
    other.credit = std::max(other.credit, want->credit_bytes);
    if (!other.wants.insert({decoder_.header().sender, decoder_.header().counter}).second) return;
    for (const wire::WantEntry& entry : want->entries)
      for (std::uint32_t i = 0; i < std::min<std::uint32_t>(entry.count, 64); ++i)
        ++here.owed[{from, {entry.id, entry.first + i}}].asked;
  }
}

void Watch::sent(std::size_t from, const OutgoingDatagram& datagram) {
  Seen& here = seen(from);
  ++looks_;
  if (datagram.size > kMaxDatagramBytes) broke(from, fmt::format("a datagram of {} bytes", datagram.size));
  const auto& peers = net_[from].config.peers;
  if (datagram.to == SimNet::group()) return;
  Stranger& other = here.others[datagram.to];
  const bool configured = std::find(peers.begin(), peers.end(), datagram.to) != peers.end();
  other.out += datagram.size;
  if (!configured && !other.proved) other.proved = lives_there(from, datagram.to);
  if (!configured && !other.proved && other.out > other.in)
    broke(from, fmt::format("{} bytes to an address that sent {} and proved nothing", other.out, other.in));
  if (net_[from].config.sealed) return look_at_seal(from, here, datagram);
  if (decoder_.decode(datagram.bytes()) != Refusal::count) return broke(from, "it sends what nobody can read");
  for (const wire::Frame& frame : decoder_.frames()) {
    const auto* data = std::get_if<wire::Data>(&frame);
    if (data == nullptr) continue;
    const bool pushed = data->id.log.lane <= wire::kLastPushedLane && data->total_bytes <= wire::kFragmentBytes;
    Owes& owes = here.owed[{datagram.to, {data->id, data->fragment}}];
    if (++owes.sent > owes.asked + (pushed ? kMostPushes : 0) && data->fragment < 64)
      broke(from, fmt::format("fragment {} of {} is sent {} times and was asked for {} times", data->fragment,
                              text(data->id), owes.sent, owes.asked));
  }
}

// Under a session, which proves the address; or found by multicast, where a greeting is the only way to ask.
bool Watch::lives_there(std::size_t robot, const Endpoint& at) const {
  if (!net_[robot].config.sealed) return false;
  if (net_[robot].config.group) return true;
  const auto neighbours = net_[robot].node->neighbours();
  return std::ranges::any_of(neighbours, [&](const auto& one) { return one.alive && one.endpoint == at; });
}

// Two datagrams under one key and number would give both away.
void Watch::look_at_seal(std::size_t from, Seen& here, const OutgoingDatagram& datagram) {
  const auto bytes = datagram.bytes();
  if (bytes.size() < sealed::kOverheadBytes || bytes[0] != sealed::kMagicAndVersion)
    return broke(from, "it sends what is not sealed");
  if (bytes[1] != static_cast<std::uint8_t>(sealed::Type::frames)) return;
  const Number number{sealed::index_at(bytes, sealed::kHeadBytes), sealed::counter_of(bytes)};
  if (!here.numbers.insert(number).second)
    broke(from, fmt::format("number {} of session {} is used twice", number.counter, number.session));
}

}  // namespace onemap::comms::sim
