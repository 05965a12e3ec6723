#include "sim/sim_net.hpp"

#include <algorithm>
#include <utility>

namespace onemap::comms::sim {

bool agrees(const Node& node, std::size_t robots, std::uint8_t flags) {
  return node.team().size() >= robots && node.team_agrees(flags, {});
}

RobotId numbered(std::string name, std::size_t i) {
  name += std::to_string(i);
  return RobotId::from_name(name);
}

void Robot::start(std::uint64_t seed) {
  end();
  if (!config.identity) config.identity = identity_of(config.self);
  node = std::make_unique<Node>(config, *store);
  if (!config.sealed) return;
  GuardConfig g{config.self, config.incarnation, config.group, team, *config.identity, {}, {}, 64};
  g.random = [random = Random(seed)](std::span<std::uint8_t> bytes) mutable {
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
  };
  guard = std::make_unique<Guard>(std::move(g), *node, *pins);
}

void Robot::end() {
  guard.reset();
  node.reset();
}

void Robot::on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes) {
  guard ? guard->on_datagram(now, from, bytes) : node->on_datagram(now, from, bytes);
}

void Robot::on_timer(Instant now) { guard ? guard->on_timer(now) : node->on_timer(now); }

Instant Robot::next_deadline() const { return guard ? guard->next_deadline() : node->next_deadline(); }

bool Robot::next_outgoing(OutgoingDatagram& datagram) {
  return guard ? guard->next_outgoing(datagram) : node->next_outgoing(datagram);
}

Counters Robot::counters() const { return guard ? guard->counters() : node->counters(); }

SimNet::SimNet(std::uint64_t seed, LinkModel model, Medium::Model medium)
    : seed_(seed), random_(seed), model_(model), medium_(medium) {}
SimNet::~SimNet() = default;

// ---- who is there

Robot& SimNet::place(std::size_t i) {
  robots_.emplace_back();
  Robot& robot = robots_.back();
  robot.endpoint = address(i);
  places_[robot.endpoint] = i;
  const std::size_t n = robots_.size();
  edges_.resize(n);
  blocked_.resize(n);
  links_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    edges_[k].resize(n);
    blocked_[k].resize(n);
    links_[k].resize(n);
  }
  return robot;
}

void SimNet::add_team(std::size_t n, const std::vector<Edge>& edges, NodeConfig base) {
  for (std::size_t i = 0; i < n; ++i) {
    base.peers.clear();
    for (const auto& [a, b] : edges) {
      if (a == i) base.peers.push_back(address(b));
      if (b == i) base.peers.push_back(address(a));
    }
    add(base);
  }
  for (const Edge& edge : edges) connect(edge.first, edge.second);
}

std::size_t SimNet::add(NodeConfig config, std::size_t store_bytes) {
  return add(std::move(config), std::make_unique<NoDisk>(store_bytes));
}

std::size_t SimNet::add(NodeConfig config, std::unique_ptr<NodeDisk> disk) {
  const std::size_t i = robots_.size();
  Robot& robot = place(i);
  if (config.self == RobotId{}) config.self = numbered("robot", i);
  robot.config = std::move(config);
  robot.disk = std::move(disk);
  robot.store = robot.disk->open();
  start_node(i);
  return i;
}

std::size_t SimNet::add(std::unique_ptr<Guest> guest) {
  const std::size_t i = robots_.size();
  place(i).guest = std::move(guest);
  guests_.push_back(i);
  settle(i);
  return i;
}

void SimNet::start_node(std::size_t i) {
  Robot& robot = robots_[i];
  robot.start(1000 * ++starts_ + i);
  if (witness != nullptr) witness->began(i);
  settle(i);
}

void SimNet::restart_node(std::size_t i) { start_node(i); }

void SimNet::restart(std::size_t i, NodeConfig config) {
  switch_off(i);
  robots_[i].disk->wipe();
  if (config.self == RobotId{}) config.self = numbered("robot", i);
  robots_[i].config = config;
  switch_on(i, config.incarnation);
}

void SimNet::switch_off(std::size_t i) {
  Robot& robot = robots_[i];
  robot.on = false;
  robot.disk->die();
  robot.end();
  robot.store.reset();
  robot.applied.clear();
  robot.waiting.clear();
  robot.stopped_until = {};
  robot.wakes_at = Instant::max();
}

void SimNet::switch_on(std::size_t i, std::uint64_t incarnation) {
  Robot& robot = robots_[i];
  robot.on = true;
  robot.config.incarnation = incarnation;
  robot.store = robot.disk->open();
  start_node(i);
}

void SimNet::stop(std::size_t i, Duration time) {
  robots_[i].stopped_until = now_ + time;
  robots_[i].wakes_at = now_ + time;
  events_.wake(now_ + time, i);
}

void SimNet::jump_clock(std::size_t i, Duration ahead) {
  robots_[i].clock += ahead;
  settle(i);
}

// ---- who hears whom

void SimNet::connect(std::size_t a, std::size_t b) { edges_[a][b] = edges_[b][a] = 1; }
void SimNet::cut(std::size_t a, std::size_t b) { edges_[a][b] = edges_[b][a] = 0; }
void SimNet::block(std::size_t from, std::size_t to) { ++blocked_[from][to]; }
void SimNet::unblock(std::size_t from, std::size_t to) { --blocked_[from][to]; }
bool SimNet::reaches(std::size_t from, std::size_t to) const {
  return edges_[from][to] != 0 && blocked_[from][to] == 0;
}

Link& SimNet::link(std::size_t from, std::size_t to) {
  auto& link = links_[from][to];
  if (link == nullptr) link = std::make_unique<Link>(splitmix64(seed_ ^ splitmix64(from * 65'537 + to)));
  return *link;
}

// ---- what happens

RecordId SimNet::append(std::size_t i, std::uint8_t lane, std::size_t bytes, std::uint16_t kind) {
  return try_append(i, lane, bytes, kind).value();
}

std::optional<RecordId> SimNet::try_append(std::size_t i, std::uint8_t lane, std::size_t bytes, std::uint16_t kind,
                                           std::uint32_t replaces) {
  std::vector<std::uint8_t> body(bytes);
  for (auto& byte : body) byte = static_cast<std::uint8_t>(random_.next() >> 56);
  const auto id = node(i).append(clock_of(robots_[i]), lane, kind, body, replaces);
  if (id.ok()) {
    useful_bytes_ += bytes;
    if (witness != nullptr) witness->appended(i, {*id, kind, std::move(body), {}, {}});
  }
  settle(i);
  return id.ok() ? std::optional(*id) : std::nullopt;
}

void SimNet::inject(std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes) {
  robots_[to].on_datagram(clock_of(robots_[to]), from, bytes);
  settle(to);
}

bool SimNet::run_until(const std::function<bool()>& done, Duration limit) {
  const Instant end = now_ + limit;
  for (std::size_t i = 0; i < robots_.size(); ++i) settle(i);
  while (!done()) {
    if (events_.empty() || events_.top().at > end) return now_ = end, done();
    now_ = std::max(now_, events_.top().at);
    step();
  }
  return true;
}

void SimNet::run_for(Duration time) {
  run_until([] { return false; }, time);
}

bool SimNet::equal() const {
  const Robot* first = nullptr;
  for (const Robot& robot : robots_) {
    if (!robot.on || robot.node == nullptr) continue;
    if (first == nullptr) first = &robot;
    if (robot.node->frontier() != first->node->frontier()) return false;
  }
  return true;
}

void SimNet::step() {
  const EventQueue::Event event = events_.pop();
  if (event.kind == EventQueue::Kind::waking) return wake(event.which);
  Flight flight = events_.take(event.which);
  arrive(flight);
  events_.give_back(event.which, std::move(flight));
}

void SimNet::arrive(Flight& flight) {
  Robot& robot = robots_[flight.to];
  if (!robot.on || !reaches(flight.sender, flight.to)) return;
  if (robot.stopped_until > now_) {
    if (robot.waiting.size() < kSocketDatagrams) robot.waiting.push_back(flight);
    return;
  }
  if (tap) tap(flight.to, flight.from, flight.bytes);
  if (robot.guest != nullptr) {
    robot.guest->hear(now_, flight.from, robot.endpoint, flight.bytes);
    return settle(flight.to);
  }
  if (witness != nullptr) witness->arrives(flight.to, flight.from, flight.bytes);
  robot.on_datagram(clock_of(robot), flight.from, flight.bytes);
  settle(flight.to);
}

void SimNet::wake(std::size_t i) {
  Robot& robot = robots_[i];
  if (!robot.on || now_ < robot.wakes_at) return;
  robot.wakes_at = Instant::max();
  if (robot.guest != nullptr) {
    robot.guest->speak(now_, [&](const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes) {
      transmit(i, from, to, bytes);
    });
    return settle(i);
  }
  for (auto waiting = std::exchange(robot.waiting, {}); const Flight& flight : waiting) {
    if (witness != nullptr) witness->arrives(i, flight.from, flight.bytes);
    robot.on_datagram(clock_of(robot), flight.from, flight.bytes);
  }
  if (robot.next_deadline() <= clock_of(robot)) robot.on_timer(clock_of(robot));
  settle(i);
}

void SimNet::settle(std::size_t i) {
  Robot& robot = robots_[i];
  if (!robot.on || robot.stopped_until > now_) return;
  Instant next = Instant::max();
  if (robot.guest != nullptr) {
    next = robot.guest->next();
  } else {
    OutgoingDatagram datagram;
    while (robot.next_outgoing(datagram)) {
      if (witness != nullptr) witness->sent(i, datagram);
      transmit(i, robot.endpoint, datagram.to, datagram.bytes());
    }
    std::shared_ptr<const Record> record;
    while (robot.node->next_applied(record)) {
      if (witness != nullptr) witness->applied(i, *record);
      if (on_applied) on_applied(i, *record);
      robot.applied.push_back(record);
    }
    next = robot.next_deadline();
    if (next != Instant::max()) next -= robot.clock;
  }
  if (witness != nullptr) witness->moved(i);
  next = std::max(next, now_);
  if (next >= robot.wakes_at) return;
  robot.wakes_at = next;
  events_.wake(next, i);
}

// ---- the way there

void SimNet::transmit(std::size_t sender, const Endpoint& from, const Endpoint& to,
                      std::span<const std::uint8_t> bytes) {
  bytes_carried_ += bytes.size();
  ++datagrams_carried_;
  largest_ = std::max(largest_, bytes.size());
  const auto departs =
      medium_.send(now_, sender, robots_.size(), bytes.size(), [&](std::size_t who) { return reaches(sender, who); });
  if (!departs) return;
  if (!guests_.empty()) overhear(sender, from, to, bytes);
  if (to == group()) {
    for (std::size_t who = 0; who < robots_.size(); ++who)
      if (who != sender && robots_[who].config.group) carry(sender, who, from, *departs, bytes);
    return;
  }
  if (const auto at = places_.find(to); at != places_.end()) carry(sender, at->second, from, *departs, bytes);
}

void SimNet::carry(std::size_t sender, std::size_t to, const Endpoint& from, Instant departs,
                   std::span<const std::uint8_t> bytes) {
  if (sender == to || !reaches(sender, to)) return;
  const Link::Fate fate = link(sender, to).send(model_, departs, bytes.size());
  for (std::size_t copy = 0; copy < fate.copies; ++copy) {
    const Link::Arrival& arrival = fate.arrivals[copy];
    Flight& flight = events_.launch(arrival.at);
    flight.sender = sender;
    flight.to = to;
    flight.from = from;
    flight.bytes.assign(bytes.begin(), bytes.end());
    if (arrival.flipped_bit)
      flight.bytes[*arrival.flipped_bit / 8] ^= static_cast<std::uint8_t>(1u << (*arrival.flipped_bit % 8));
  }
}

// Radio is heard by whoever is near.
void SimNet::overhear(std::size_t sender, const Endpoint& from, const Endpoint& to,
                      std::span<const std::uint8_t> bytes) {
  for (const std::size_t guest : guests_)
    if (guest != sender && robots_[guest].endpoint != to && reaches(sender, guest))
      robots_[guest].guest->hear(now_, from, to, bytes);
}

}  // namespace onemap::comms::sim
