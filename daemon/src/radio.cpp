#include "daemon/radio.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>

#include "daemon/addresses.hpp"
#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr int kDatagramsAtOnce = 64;
constexpr auto kLongestSleep = std::chrono::milliseconds(100);
constexpr auto kLookInterval = std::chrono::milliseconds(50);
constexpr auto kRadioStuckAfter = std::chrono::seconds(10);
}  // namespace

Radio::Radio(const Config& config, Store store, comms::NodeConfig node, LifeCounter life,
             std::unique_ptr<comms::DatagramPort> port, std::unique_ptr<TeamSeal> seal, Listener listener,
             Failures& failures, Log& log)
    : config_(config),
      failures_(failures),
      log_(log),
      listener_(std::move(listener)),
      life_(std::move(life)),
      node_config_(std::move(node)),
      store_(std::move(store)),
      port_(std::move(port)),
      seal_(std::move(seal)),
      heartbeat_("radio", kRadioStuckAfter) {
  begin_node();
}

void Radio::begin_node() {
  guard_.reset();  // it knows the node that goes
  node_ = std::make_unique<comms::Node>(node_config_, *store_.log);
  if (seal_) guard_ = seal_->guard(node_config_, *node_);
}

// The node's, through the guard if there is one.
void Radio::on_timer(Instant now) { guard_ ? guard_->on_timer(now) : node_->on_timer(now); }
Instant Radio::next_deadline() const { return guard_ ? guard_->next_deadline() : node_->next_deadline(); }
bool Radio::next_outgoing(comms::OutgoingDatagram& datagram) {
  return guard_ ? guard_->next_outgoing(datagram) : node_->next_outgoing(datagram);
}
comms::Counters Radio::counters() const { return guard_ ? guard_->counters() : node_->counters(); }

Radio::~Radio() { stop(); }

void Radio::start() {
  // However the thread ends, nobody waits for room in its outbox, or for an answer.
  thread_.start(
      "radio", failures_, [this] { run(); },
      [this] {
        outbox_.close();
        asked_.close();
      });
}

void Radio::stop(Duration linger) {
  linger_until_ns_ = (now() + linger).time_since_epoch().count();
  stopping_ = true;
  port_->wake();
  thread_.join();
}

void Radio::publish(OutgoingRecord record) {
  outbox_.push(std::move(record));
  ++handed_in_;
  port_->wake();
}

void Radio::finish(std::uint32_t frames) {
  {
    const std::lock_guard lock(mutex_);
    finish_ = frames;
  }
  ++handed_in_;
  port_->wake();
}

bool Radio::settle(Duration most) {
  constexpr auto kLook = std::chrono::milliseconds(2);
  const std::uint64_t handed_in = handed_in_;
  for (const Instant end = now() + most; settled_ < handed_in; std::this_thread::sleep_for(kLook))
    if (failures_.any() || now() >= end) return false;
  return true;
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

void Radio::spare(mapping::SpareRecords records) {
  const std::lock_guard lock(mutex_);
  spare_.needless.insert(spare_.needless.end(), records.needless.begin(), records.needless.end());
  spare_.unread.insert(spare_.unread.end(), records.unread.begin(), records.unread.end());
  std::ranges::move(records.keyframes, std::back_inserter(spare_.keyframes));
}

void Radio::leave_out(std::set<RobotId> gone) {
  const std::lock_guard lock(mutex_);
  gone_ = std::move(gone);
}

bool Radio::ask(const Question& question, const std::atomic<bool>& stop) {
  return asked_.run([&] { question(*node_, *store_.log); }, stop);
}

RadioView Radio::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

void Radio::run() {
  while (!over(now())) {
    heartbeat_.beat(now());
    turn();
    const Duration sleep = std::min<Duration>(next_deadline() - now(), kLongestSleep);
    if (sleep > Duration::zero()) port_->wait(sleep);
  }
  turn();
  update_view(now());
  heartbeat_.rest();
}

bool Radio::over(Instant now) {
  if (!stopping_) return false;
  if (now.time_since_epoch().count() >= linger_until_ns_) return true;
  const std::lock_guard lock(mutex_);
  return outbox_.used() == 0 && !finish_ && !frames_to_finish_ && node_->delivered(1);
}

void Radio::turn() {
  const std::uint64_t handed_in = handed_in_;
  receive_some();
  const Instant t = now();
  if (node_->outlived()) begin_new_life(t);
  append_published(t);
  asked_.do_all();
  if (t >= next_deadline()) on_timer(t);
  comms::OutgoingDatagram datagram;
  while (next_outgoing(datagram)) ++(port_->send(datagram) ? sends_ : sends_failed_);
  const bool all = hand_out_applied();
  if (all && !frames_to_finish_ && node_->own_settled()) settled_ = handed_in;
  if (t - looked_ < kLookInterval) return;
  looked_ = t;
  node_->bring(t, comms::Scalar::clock_offset, to_seconds(wall_clock_offset()));
  if (brightness_ > 0) node_->bring(t, comms::Scalar::brightness, brightness_);
  log_neighbours();
  log_conflict(t);
  log_refusals();
  log_complaints();
  log_network();
  log_disk();
  log_guard();
  update_view(t);
}

// False: some wait, for want of room.
bool Radio::hand_out_applied() {
  std::shared_ptr<const Record> record;
  while (listener_.has_room()) {
    if (!node_->next_applied(record)) return true;
    hand_out(std::move(record));
  }
  return false;
}

void Radio::hand_out(std::shared_ptr<const Record> record) {
  RecordTally& tally = records_[record->id.log.robot];
  const std::size_t kind = record->kind < RecordTally::kKinds ? record->kind : 0;
  ++tally.records[kind];
  tally.bytes[kind] += record->body.size();
  listener_.applied(std::move(record));
}

void Radio::receive_some() {
  comms::IncomingDatagram datagram;
  for (int i = 0; i < kDatagramsAtOnce && port_->receive(datagram); ++i) receive(datagram);
}

void Radio::receive(const comms::IncomingDatagram& datagram) {
  if (guard_) return guard_->on_datagram(now(), datagram.from, datagram.bytes());
  if (is_loopback(datagram.from)) return node_->on_datagram(now(), datagram.from, datagram.bytes());
  ++not_loopback_;
  log_.limited("not loopback", "refused: a datagram from {}, another machine; this robot has no team key ({} so far)",
               comms::to_string(datagram.from), not_loopback_);
}

// The protocol asks again for whatever was lost; people want to know that there is no network.
void Radio::log_network() {
  if (config_.alone() || sends_ + sends_failed_ == 0) return;
  const bool cut_off = sends_ == 0;
  failed_before_ += std::exchange(sends_failed_, 0u);
  sends_ = 0;
  if (cut_off && !cut_off_)
    log_.warn(
        "nothing can be sent: is there a network, with a route to the peers? Mapping goes on, and what is new is "
        "sent when there is one");
  if (!cut_off && cut_off_) log_.line("the network takes datagrams again, after {} that it did not", failed_before_);
  cut_off_ = cut_off;
}

void Radio::log_neighbours() {
  for (const comms::NeighbourStatus& neighbour : node_->neighbours()) {
    bool& alive = alive_[neighbour.robot];
    if (alive == neighbour.alive) continue;
    alive = neighbour.alive;
    log_.line("neighbour {} at {} {}", neighbour.robot.name(), comms::to_string(neighbour.endpoint),
              alive ? "is heard" : "fell silent");
  }
}

}  // namespace onemap::daemon
