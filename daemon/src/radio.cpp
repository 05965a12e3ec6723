#include "daemon/radio.hpp"

#include <algorithm>
#include <chrono>

#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr int kDatagramsAtOnce = 64;
constexpr auto kLongestSleep = std::chrono::milliseconds(100);
constexpr auto kLookInterval = std::chrono::milliseconds(50);

Result<comms::NodeConfig> node_config(const Config& config) {
  comms::NodeConfig node;
  node.self = RobotId::from_name(config.id);
  node.incarnation = wall_clock_ns();
  node.bytes_per_second = config.bytes_per_second;
  for (const std::string& peer : config.peers) {
    auto endpoint = comms::parse_endpoint(peer);
    if (!endpoint) return Error{"peer " + endpoint.error().place, endpoint.error().reason};
    node.peers.push_back(*endpoint);
  }
  return node;
}
}  // namespace

Result<std::unique_ptr<Radio>> Radio::open(const Config& config, Applied applied, Log& log) {
  auto node = node_config(config);
  if (!node) return node.error();
  auto listen = comms::parse_endpoint(config.listen.empty() ? "0.0.0.0:0" : config.listen);
  if (!listen) return Error{"listen " + listen.error().place, listen.error().reason};
  comms::UdpConfig udp;
  udp.listen = *listen;
  auto port = comms::UdpPort::open(udp);
  if (!port) return port.error();
  return std::unique_ptr<Radio>(new Radio(config, std::move(*node), std::move(*port), std::move(applied), log));
}

Radio::Radio(const Config& config, comms::NodeConfig node, std::unique_ptr<comms::UdpPort> port, Applied applied,
             Log& log)
    : log_(log),
      applied_(std::move(applied)),
      store_(config.store_budget_bytes),
      port_(std::move(port)),
      node_(std::move(node), store_) {}

Radio::~Radio() { stop(); }

void Radio::start() { thread_ = std::thread(&Radio::run, this); }

void Radio::stop() {
  stopping_ = true;
  port_->wake();
  if (thread_.joinable()) thread_.join();
}

void Radio::publish(OutgoingRecord record) {
  {
    const std::lock_guard lock(mutex_);
    outbox_.push_back(std::move(record));
  }
  port_->wake();
}

void Radio::say(std::uint64_t map_digest, bool finished) {
  const std::uint8_t flags = finished ? comms::kStatusFinished : 0;
  {
    const std::lock_guard lock(mutex_);
    if (map_digest == map_digest_ && flags == flags_) return;
    map_digest_ = map_digest;
    flags_ = flags;
  }
  port_->wake();
}

RadioView Radio::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

void Radio::run() {
  while (!stopping_) {
    turn();
    const Duration sleep = std::min<Duration>(node_.next_deadline() - now(), kLongestSleep);
    if (sleep > Duration::zero()) port_->wait(sleep);
  }
}

void Radio::turn() {
  receive_some();
  const Instant t = now();
  append_published(t);
  if (t >= node_.next_deadline()) node_.on_timer(t);
  comms::OutgoingDatagram datagram;
  while (node_.next_outgoing(datagram)) port_->send(datagram);
  std::shared_ptr<const Record> record;
  while (node_.next_applied(record)) applied_(std::move(record));
  if (t - looked_ < kLookInterval) return;
  looked_ = t;
  log_neighbours();
  update_view();
}

void Radio::receive_some() {
  comms::IncomingDatagram datagram;
  for (int i = 0; i < kDatagramsAtOnce && port_->receive(datagram); ++i)
    node_.on_datagram(now(), datagram.from, datagram.bytes());
}

void Radio::append_published(Instant now) {
  std::vector<OutgoingRecord> records;
  {
    const std::lock_guard lock(mutex_);
    records.swap(outbox_);
    node_.set_local_status(now, map_digest_, flags_);
    said_digest_ = map_digest_;
  }
  for (OutgoingRecord& record : records) {
    const auto lane = static_cast<std::uint8_t>(record.lane);
    const auto kind = static_cast<std::uint16_t>(record.kind);
    const std::size_t bytes = record.body.size();
    if (!node_.append(now, lane, kind, std::move(record.body)))
      log_.limited("store",
                   "record of kind {} with {} bytes refused: too large, or the store's {} of {} bytes are used", kind,
                   bytes, store_.used(), store_.capacity());
  }
}

void Radio::log_neighbours() {
  for (const comms::NeighbourStatus& neighbour : node_.neighbours()) {
    bool& alive = alive_[neighbour.robot];
    if (alive == neighbour.alive) continue;
    alive = neighbour.alive;
    log_.line("neighbour {} at {} {}", neighbour.robot.name(), comms::to_string(neighbour.endpoint),
              alive ? "is heard" : "fell silent");
  }
}

void Radio::update_view() {
  const std::lock_guard lock(mutex_);
  view_.frontier_digest = node_.frontier_digest();
  view_.robots_heard = node_.team().size();
  view_.neighbours_heard = alive_.size();
  view_.records_missing = node_.records_missing();
  view_.agrees = node_.team_agrees(1, comms::kStatusFinished);
  view_.agreed_digest = view_.agrees ? said_digest_ : 0;
  view_.bytes_sent = node_.counters().bytes_sent;
  view_.bytes_received = node_.counters().bytes_received;
}

}  // namespace onemap::daemon
