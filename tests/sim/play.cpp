#include "sim/play.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace onemap::comms::sim {

namespace {
using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr std::uint64_t kFirstLife = 1'000'000, kLifeStep = 1000;
constexpr unsigned kMostNewLives = 3;  // the daemon's
constexpr auto kStep = milliseconds(100);
// Who lies in well-formed frames, in the open, can hold others up, and no longer than this after it has gone, and while
// it stays: what it claimed to hold is asked of it, and counts that were never true have to be found out.
// Who has no key can pass on a handshake between two who then speak to each other through it, until they notice.
constexpr auto kAfterAHandshakeThatWasPassedOn = seconds(3);
// Of an earlier life nobody believes a greeting, so the others' are waited for, and half a second more by the higher
// id.
constexpr auto kAfterAForgottenLife = seconds(1);
constexpr auto kAfterTheHostile = seconds(12), kBesideTheHostile = seconds(30);

Duration allowed_for(const Scenario& scenario) {
  const auto forgets = [](const Fault& fault) { return fault.kind == Fault::Kind::forget_life; };
  if (!scenario.hostile)
    return scenario.sealed && std::ranges::any_of(scenario.faults, forgets) ? kAfterAForgottenLife : Duration{};
  if (scenario.sealed) return kAfterAHandshakeThatWasPassedOn;
  return scenario.hostile_stays ? kBesideTheHostile : kAfterTheHostile;
}
constexpr std::size_t kStoreBytes = 16u << 20;

Keeping keeping_of(std::uint16_t kind) {
  if (kind == kUntilTheNext) return Keeping::until_the_next;
  return kind == kUntilItMayGo ? Keeping::until_it_may_go : Keeping::always;
}
}  // namespace

Play::Play(const Scenario& scenario)
    : scenario_(scenario),
      random_(splitmix64(scenario.seed ^ 0x9A7)),
      net_(scenario.seed, scenario.links, scenario.air),
      watch_(net_),
      field_(scenario.field, scenario.robots, random_),
      lives_(scenario.robots),
      off_(scenario.robots) {
  const bool moving = scenario.field.reach > 0;
  for (std::size_t i = 0; i < scenario.robots; ++i) {
    NodeConfig config = scenario.node;
    config.keeping = keeping_of;
    config.sealed = scenario.sealed;
    lives_[i].number = config.incarnation = kFirstLife + i;
    if (moving) config.group = SimNet::group();
    for (const auto& [a, b] : scenario.edges) {
      if (moving) break;
      if (a == i) config.peers.push_back(SimNet::address(b));
      if (b == i) config.peers.push_back(SimNet::address(a));
    }
    if (scenario.disks)
      net_.add(config, std::make_unique<LogDisk>(kStoreBytes, scenario.sync_polls));
    else
      net_.add(config, std::make_unique<NoDisk>(kStoreBytes));
  }
  if (moving)
    field_.apply(net_);
  else
    for (const Edge& edge : scenario.edges) net_.connect(edge.first, edge.second);
  if (scenario.hostile) {
    auto hostile = std::make_unique<Hostile>(scenario.seed, SimNet::address(scenario.robots));
    hostile_ = hostile.get();
    const std::size_t place = net_.add(std::move(hostile));
    for (std::size_t i = 0; i < scenario.robots; ++i)
      if (i == 0 || random_.below(2) == 0) net_.connect(i, place);
  }
  net_.on_applied = [this](std::size_t robot, const Record& record) { let_go(robot, record); };
  for (const Write& write : scenario.writes) plan(write);
  for (const Fault& fault : scenario.faults) plan(fault);
}

void Play::at(Duration when, std::function<void()> what) { plan_.emplace(Instant(seconds(1)) + when, std::move(what)); }

void Play::plan(const Write& write) {
  at(write.at, [this, write] {
    if (!net_.runs(write.robot) || net_[write.robot].stopped_until > net_.now()) return;
    std::uint32_t replaces = kNoSequence;
    const LogId log{net_[write.robot].config.self, write.lane, net_[write.robot].config.incarnation};
    const auto last = last_that_may_go_.find(log);
    if (write.kind == kUntilItMayGo && last != last_that_may_go_.end()) replaces = last->second;
    const auto id = net_.try_append(write.robot, write.lane, write.bytes, write.kind, replaces);
    if (id && write.kind == kUntilItMayGo) last_that_may_go_[log] = id->seq;
  });
}

// As a daemon whose map does without what was replaced: sooner, or never.
void Play::let_go(std::size_t robot, const Record& record) {
  const auto& [log, seq] = record.id;
  if (record.kind != kUntilItMayGo || record.seal.replaces >= seq || splitmix64(seq * 31 + robot) % 3 == 0) return;
  net_.node(robot).let_go({log, record.seal.replaces});
}

void Play::plan(const Fault& fault) {
  using Kind = Fault::Kind;
  const Duration end = std::min(fault.at + fault.lasts, scenario_.chaos);
  const std::size_t i = fault.robot;
  switch (fault.kind) {
    case Kind::partition:
      at(fault.at, [this, fault] { divide(fault, true); });
      at(end, [this, fault] { divide(fault, false); });
      break;
    case Kind::clog:
      at(fault.at, [this, fault, end] { net_.clog(fault.robot, fault.other, Instant(seconds(1)) + end); });
      break;
    case Kind::crash:
    case Kind::wipe:
    case Kind::forget_life:
      at(fault.at, [this, fault] { power_off(fault); });
      at(end, [this, fault] { power_on(fault); });
      break;
    case Kind::stop:
      at(fault.at, [this, i, end] {
        if (net_.runs(i)) net_.stop(i, Instant(seconds(1)) + end - net_.now());
      });
      break;
    case Kind::clock_jump:
      at(fault.at, [this, i, fault] {
        if (net_.runs(i)) net_.jump_clock(i, fault.lasts);
      });
      break;
    case Kind::full_disk:
      at(fault.at, [this, i] { net_[i].disk->fill(true); });
      at(end, [this, i] { net_[i].disk->fill(false); });
      break;
    case Kind::storm:
      at(fault.at, [this, fault] { net_.model().loss = fault.loss; });
      at(end, [this] { net_.model().loss = scenario_.links.loss; });
      break;
  }
}

void Play::divide(const Fault& fault, bool apart) {
  for (std::size_t a = 0; a < scenario_.robots; ++a)
    for (std::size_t b = 0; b < scenario_.robots; ++b) {
      if (fault.side[a] == fault.side[b] || (fault.one_way && !fault.side[a])) continue;
      if (apart)
        net_.block(a, b);
      else
        net_.unblock(a, b);
    }
}

void Play::power_off(const Fault& fault) {
  if (off_[fault.robot]++ == 0) {
    net_.switch_off(fault.robot);
    net_[fault.robot].disk->crash(random_);
  }
  if (fault.kind == Fault::Kind::crash) return;
  net_[fault.robot].disk->wipe();
  watch_.wiped(fault.robot);
}

void Play::power_on(const Fault& fault) {
  const std::size_t i = fault.robot;
  if (--off_[i] > 0) return;
  Life& life = lives_[i];
  // Never a number that was used: its clock is wrong, and not the same for the second time.
  life.number += fault.kind == Fault::Kind::forget_life ? std::uint64_t(0) - kLifeStep / 2 - 7 : kLifeStep;
  life.begun_after_others = 0;
  net_.switch_on(i, life.number);
  if (scenario_.disks) watch_.came_back(i);
}

void Play::outlive() {
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    if (!net_.runs(i) || !net_.node(i).outlived() || lives_[i].begun_after_others == kMostNewLives) continue;
    ++lives_[i].begun_after_others;
    lives_[i].number = std::max(lives_[i].number, *net_.node(i).outlived()) + 1;
    net_[i].config.incarnation = lives_[i].number;
    net_.restart_node(i);
  }
}

void Play::move() {
  field_.drive(kStep);
  field_.apply(net_);
}

void Play::check() {
  if (watch_.broken()) fail(watch_.what());
}

void Play::until(Instant when) {
  while (failure_.empty() && net_.now() < when) {
    const Instant next = plan_.empty() ? when : std::min(plan_.begin()->first, when);
    net_.run_until([&] { return watch_.broken(); }, std::min<Duration>(next - net_.now(), kStep));
    check();
    outlive();
    while (!plan_.empty() && plan_.begin()->first <= net_.now()) {
      const auto what = std::move(plan_.begin()->second);
      plan_.erase(plan_.begin());
      what();
    }
    check();
  }
}

void Play::faults() {
  const Instant end = Instant(seconds(1)) + scenario_.chaos;
  if (scenario_.field.reach > 0)
    for (Duration t{}; t < scenario_.chaos; t += kStep) at(t, [this] { move(); });
  until(end + Duration(1));  // what ends with the faults has ended
}

// Links stay as lossy as they are; bits are not flipped any more, and nothing is clogged.
void Play::peace() {
  if (!failure_.empty()) return;
  net_.model() = scenario_.links;
  net_.model().flipped = 0;
  net_.model().burst_every = {};
  if (scenario_.field.reach > 0) {
    field_.gather();
    field_.apply(net_);
  }
  if (hostile_ != nullptr && !scenario_.hostile_stays) hostile_->fall_silent();
  Instant begin = net_.now();
  bound_ = bound();
  Duration limit = bound_ + bound_ / 2 + seconds(2) + allowed_for(scenario_);
  converge(begin + limit);
  if (failure_.empty() && !equal() && names_taken()) {
    begin = net_.now();
    bound_ = bound();
    limit = bound_ + bound_ / 2 + seconds(2) + kAfterTheHostile;
    hostile_->fall_silent();
  }
  constexpr auto kPatience = seconds(60);  // to see whether it happens at all
  converge(begin + std::max<Duration>(limit, kPatience));
  recovery_ = net_.now() - begin;
  if (!equal())
    return fail(
        fmt::format("after {:.3f} s of peace the records are not the same: {}", to_seconds(recovery_), difference()));
  if (recovery_ > limit)
    fail(fmt::format("equal after {:.3f} s of peace; links and air need {:.3f} s, so {:.3f} s are allowed",
                     to_seconds(recovery_), to_seconds(bound_), to_seconds(limit)));
  until(net_.now() + seconds(1));
  if (!equal() && hostile_ == nullptr) fail("equal, and then not any more: " + difference());
  for (std::size_t i = 1; i < scenario_.robots; ++i)
    if (net_.node(i).frontier() == net_.node(0).frontier() && watch_.set_hash(i) != watch_.set_hash(0))
      fail("equal frontiers, and not the same records");
  for (std::size_t i = 0; i < scenario_.robots; ++i)
    if (net_.runs(i)) watch_.look_at_bodies(i);
  check();
}

void Play::converge(Instant until) {
  while (failure_.empty() && !equal() && net_.now() < until) {
    // Two digests are soon compared, two frontiers are not.
    if (hostile_ == nullptr)
      net_.run_until([&] { return watch_.broken() || equal(); }, kStep);
    else
      net_.run_until([&] { return watch_.broken(); }, kStep / 10);
    check();
    outlive();
  }
}

// In the open nothing shows who it is that greets: while somebody lives under a robot's name at a neighbour of that
// robot, the robot is refused there. All that is promised is that this is counted, and that it ends with the hostile
// one.
bool Play::names_taken() {
  if (hostile_ == nullptr || !scenario_.hostile_stays || scenario_.sealed) return false;
  bool taken = false;
  for (std::size_t i = 0; i < scenario_.robots; ++i)
    for (const NeighbourStatus& one : net_.node(i).neighbours()) {
      if (!one.alive || one.endpoint != SimNet::address(scenario_.robots)) continue;
      for (std::size_t k = 0; k < scenario_.robots; ++k) {
        if (one.robot != net_[k].config.self) continue;
        taken = true;  // what others bring of its present life is refused, too
        if (!net_.reaches(k, i)) continue;
        const Counters& counted = net_.node(i).counters();
        if (counted.of(Refusal::id_conflict) + counted.of(Refusal::second_path) == 0)
          fail(fmt::format("robot{} has somebody else for robot{} and does not say so", i, k));
      }
    }
  return taken;
}

// Of what honest robots wrote: a hostile one's own log may grow in one place for as long as it likes.
bool Play::equal() const {
  for (std::size_t i = 0; i < scenario_.robots; ++i)
    if (!net_.runs(i)) return false;
  const auto honest_part = [&](std::size_t i) {
    VersionVector part = net_.node(i).frontier();
    if (hostile_ != nullptr)
      std::erase_if(part, [](const auto& entry) { return !entry.first.robot.name().starts_with("robot"); });
    return part;
  };
  if (hostile_ == nullptr) {
    for (std::size_t i = 1; i < scenario_.robots; ++i)
      if (net_.node(i).frontier_digest() != net_.node(0).frontier_digest()) return false;
    return net_.equal();
  }
  const VersionVector first = honest_part(0);
  for (std::size_t i = 1; i < scenario_.robots; ++i)
    if (honest_part(i) != first) return false;
  return true;
}

// What that robot says of it.
std::string Play::why_missing(std::size_t robot) const {
  const Node& node = net_.node(robot);
  const std::string full = node.store_full();
  return fmt::format(", which knows of {} more that neighbours have{}{}", node.records_missing(),
                     full.empty() ? "" : ": ", full);
}

std::string Play::difference() const {
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    if (!net_.runs(i)) return fmt::format("robot{} is off", i);
    for (const auto& [log, count] : net_.node(i).frontier())
      for (std::size_t k = 0; k < scenario_.robots; ++k) {
        const auto& other = net_.node(k).frontier();
        const auto at = other.find(log);
        const std::uint32_t there = at == other.end() ? 0 : at->second;
        if (there < count)
          return fmt::format("of {}/{}/{} robot{} holds {} and robot{} {}{}", log.robot.name(), log.incarnation,
                             log.lane, i, count, k, there, why_missing(k));
      }
  }
  return "nothing";
}

Outcome Play::outcome() {
  Outcome out;
  out.failure = failure_;
  out.recovery = recovery_;
  out.bound = bound_;
  out.time = net_.now() - Instant(seconds(1));
  out.datagrams = net_.datagrams_carried();
  out.looks = watch_.looks();
  out.digest = splitmix64(net_.bytes_carried()) ^ static_cast<std::uint64_t>(out.time.count());
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    if (!net_.runs(i)) continue;
    out.digest = splitmix64(out.digest) + net_.node(i).frontier_digest() + net_.node(i).counters().bytes_received;
    out.records = std::max<std::uint64_t>(out.records, net_[i].applied.size());
  }
  return out;
}

}  // namespace onemap::comms::sim
