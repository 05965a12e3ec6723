// Ours, as onemapd speaks in a team with a key: every datagram is sealed.
#include <algorithm>
#include <deque>
#include <random>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/udp/udp_port.hpp"
#include "peer.hpp"

namespace onemap::bench {

namespace {
constexpr std::size_t kAhead = 8'000'000;  // bytes of bulk that wait

Instant now() { return Instant(Clock::now().time_since_epoch()); }

struct Side {
  comms::MemoryStore store{512u << 20};
  std::unique_ptr<comms::UdpPort> port;
  comms::Pins pins;
  std::unique_ptr<comms::Node> node;
  std::unique_ptr<comms::Guard> guard;

  bool open(const Job& job) {
    const auto with_port = [](const std::string& address) {  // 10.0.0.1, or with another port than ours
      return *comms::parse_endpoint(address.find(':') == std::string::npos ? address + ":7447" : address);
    };
    auto opened = comms::UdpPort::open({with_port(job.here), {}});
    if (!opened) return false;
    port = std::move(*opened);
    comms::NodeConfig config;
    config.self = RobotId::from_name(job.sends ? "sender" : "receiver");
    config.peers = {with_port(job.there)};
    config.bytes_per_second = 125'000'000;
    config.identity = comms::Identity(comms::SecretSeed{static_cast<std::uint8_t>(job.sends ? 1 : 2)});
    config.sealed = true;
    node = std::make_unique<comms::Node>(config, store);
    comms::GuardConfig sealed{config.self, config.incarnation, {}, comms::TeamKey({1, 2, 3}), *config.identity, {}, {},
                              64};
    sealed.random = [device = std::make_shared<std::random_device>()](std::span<std::uint8_t> bytes) {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>((*device)());
    };
    guard = std::make_unique<comms::Guard>(std::move(sealed), *node, pins);
    return true;
  }
  template <class Applied>
  void turn(Applied applied, Duration longest) {
    const Duration sleep = std::min<Duration>(guard->next_deadline() - now(), longest);
    if (sleep > Duration::zero()) port->wait(sleep);
    comms::IncomingDatagram in;
    for (int i = 0; i < 64 && port->receive(in); ++i) guard->on_datagram(now(), in.from, in.bytes());
    if (now() >= guard->next_deadline()) guard->on_timer(now());
    comms::OutgoingDatagram out;
    while (guard->next_outgoing(out)) port->send(out);
    std::shared_ptr<const Record> record;
    while (node->next_applied(record)) applied(*record);
  }
};

int send(Side& side, const Job& job) {
  PoseClock poses(job);
  std::deque<RecordId> written;
  std::uint64_t noise = 1;
  while (true) {
    // What the neighbour has is not needed any more.
    while (!written.empty() &&
           side.node->held_by(RobotId::from_name("receiver"), written.front().log) > written.front().seq) {
      side.store.forget(written.front());
      written.pop_front();
    }
    while (written.size() * kBulkBytes < kAhead) {
      std::vector<std::uint8_t> body(kBulkBytes, static_cast<std::uint8_t>(++noise));
      written.push_back(side.node->append(now(), 3, 1, std::move(body)).value());
    }
    if (job.poses && poses.due()) side.node->append(now(), 1, 1, pose_now()).value();
    side.turn([](const Record&) {}, std::chrono::milliseconds(5));
  }
}

int receive(Side& side, const Job& job) {
  Tally tally(job.seconds);
  std::uint64_t before = 0;
  while (!tally.over()) {
    side.turn(
        [&](const Record& record) {
          if (record.id.log.lane == 1) tally.pose(record.body);
          side.store.forget(record.id);
        },
        std::chrono::milliseconds(5));
    const std::uint64_t bytes = side.node->counters().body_bytes_received;
    tally.bulk(bytes - before);
    before = bytes;
  }
  const comms::Counters& counters = side.node->counters();
  tally.print(static_cast<double>(counters.duplicate_body_bytes) /
              static_cast<double>(std::max<std::uint64_t>(1, before)));
  return 0;
}
}  // namespace

int run_onemap(const Job& job) {
  Side side;
  if (!side.open(job)) return 1;
  return job.sends ? send(side, job) : receive(side, job);
}

}  // namespace onemap::bench
