#include "sim/scenario.hpp"

#include <algorithm>

namespace onemap::comms::sim {

namespace {
using std::chrono::milliseconds;
using std::chrono::seconds;

Duration between(Random& random, Duration from, Duration to) {
  return Duration(random.integer(from.count(), to.count()));
}
bool chance(Random& random, double share) { return random.unit() < share; }

LinkModel links_of(Random& random) {
  LinkModel links;
  constexpr std::array kLosses{0.0, 0.0, 0.01, 0.05, 0.1, 0.2};
  links.loss = kLosses[random.below(kLosses.size())];
  links.delay = between(random, milliseconds(1), milliseconds(30));
  if (chance(random, 0.6)) links.jitter = between(random, Duration(1), milliseconds(20));
  if (chance(random, 0.3)) links.delay_tail = between(random, Duration(1), milliseconds(10));
  if (chance(random, 0.4)) links.duplication = 0.1 * random.unit();
  if (chance(random, 0.3)) links.held_back = 0.1 * random.unit();
  if (chance(random, 0.3)) links.flipped = 0.02 * random.unit();
  if (chance(random, 0.3)) {
    links.burst_every = between(random, milliseconds(500), seconds(5));
    links.burst_lasts = between(random, milliseconds(20), milliseconds(500));
    links.burst_loss = random.uniform(0.5, 1.0);
  }
  if (chance(random, 0.4)) links.bytes_per_second = 250'000 + random.below(2'500'000);
  return links;
}

NodeConfig node_of(Random& random) {
  NodeConfig node;
  if (chance(random, 0.5)) node.credit_bytes = 5'000 + random.below(60'000);
  if (chance(random, 0.5)) node.most_credit_bytes = node.credit_bytes * (1 + random.below(4));
  if (chance(random, 0.5)) node.reassembly_bytes = random.below(2'000'000);
  if (chance(random, 0.5)) node.bytes_per_second = 200'000 + random.below(4'000'000);
  if (chance(random, 0.5)) node.neighbour_timeout = between(random, seconds(3), seconds(20));
  return node;
}

std::vector<bool> side_of(Random& random, std::size_t robots) {
  std::vector<bool> side(robots);
  switch (random.below(3)) {
    case 0:  // one alone
      side[random.below(robots)] = true;
      break;
    case 1: {  // any number of them is as likely as any other
      std::vector<std::size_t> order(robots);
      for (std::size_t i = 0; i < robots; ++i) {
        order[i] = i;
        std::swap(order[i], order[random.below(i + 1)]);
      }
      for (std::size_t k = 1 + random.below(robots); k > 0; --k) side[order[k - 1]] = true;
      break;
    }
    default:  // each of them by a coin
      for (std::size_t i = 0; i < robots; ++i) side[i] = chance(random, 0.5);
  }
  return side;
}

Fault fault_of(Random& random, const Scenario& scenario) {
  using Kind = Fault::Kind;
  constexpr std::array kKinds{Kind::partition, Kind::partition, Kind::clog,       Kind::crash, Kind::crash,
                              Kind::wipe,      Kind::stop,      Kind::clock_jump, Kind::storm, Kind::forget_life};
  Fault fault;
  fault.kind = kKinds[random.below(kKinds.size())];
  fault.at = between(random, Duration{}, scenario.chaos);
  fault.lasts = between(random, milliseconds(10), std::max<Duration>(scenario.chaos / 2, milliseconds(20)));
  fault.robot = random.below(scenario.robots);
  fault.other = random.below(scenario.robots);
  if (fault.kind == Kind::partition) fault.side = side_of(random, scenario.robots);
  fault.one_way = chance(random, 0.3);
  fault.loss = random.uniform(0.4, 0.95);
  return fault;
}

std::size_t body_bytes(Random& random, std::uint8_t lane) {
  if (lane < 2) return random.below(200);
  switch (random.below(12)) {
    case 0:
      return random.below(20'000);
    case 1:
      return random.below(5'000);
    default:
      return random.below(64);
  }
}

void let_records_be_replaced(Random& random, Scenario& scenario) {
  if (chance(random, 0.5)) return;
  constexpr std::array kKinds{kAlways, kUntilTheNext, kUntilItMayGo, kUntilItMayGo};
  for (Write& write : scenario.writes) write.kind = kKinds[random.below(kKinds.size())];
}

void use_disks(Random& random, Scenario& scenario) {
  if (chance(random, 0.5)) scenario.sync_polls = static_cast<unsigned>(random.below(30));
  if (!chance(random, 0.3)) return;
  Fault full;
  full.kind = Fault::Kind::full_disk;
  full.robot = random.below(scenario.robots);
  full.at = between(random, Duration{}, scenario.chaos);
  full.lasts = between(random, milliseconds(10), scenario.chaos / 2);
  scenario.faults.push_back(full);
}
}  // namespace

Scenario scenario_of(std::uint64_t seed, const Size& size) {
  Random random(splitmix64(seed));
  Scenario scenario;
  scenario.seed = seed;
  scenario.robots = size.least_robots + random.below(size.most_robots - size.least_robots + 1);
  scenario.chaos = between(random, size.least, size.most);
  scenario.edges = connected(scenario.robots, random.below(scenario.robots + 1), random);
  scenario.links = links_of(random);
  scenario.node = node_of(random);
  if (chance(random, 0.3)) scenario.air = {.bytes_per_second = 500'000 + random.below(2'000'000), .overhead_bytes = 60};
  if (chance(random, 0.2)) scenario.field = {.reach = random.uniform(0.3, 0.8), .speed = random.uniform(0.0, 0.2)};
  scenario.disks = chance(random, 0.5);
  scenario.hostile = chance(random, 0.3);
  scenario.hostile_stays = chance(random, 0.5);
  for (std::size_t robot = 0; robot < scenario.robots; ++robot)
    for (std::size_t k = random.below(size.writes_of_robot + 1); k > 0; --k) {
      const auto lane = static_cast<std::uint8_t>(random.below(kLaneCount));
      scenario.writes.push_back({between(random, Duration{}, scenario.chaos), robot, lane, body_bytes(random, lane)});
    }
  for (std::size_t k = random.below(size.most_faults + 1); k > 0; --k)
    scenario.faults.push_back(fault_of(random, scenario));
  let_records_be_replaced(random, scenario);
  if (scenario.disks) use_disks(random, scenario);
  scenario.sealed = chance(random, 0.5);
  return scenario;
}

}  // namespace onemap::comms::sim
