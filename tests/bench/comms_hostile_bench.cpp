// What garbage costs a robot with a team key: datagrams a second that one core throws away, by kind.
// bench_comms_hostile
#include <fmt/format.h>

#include <chrono>
#include <functional>

#include "comms/memory_store.hpp"
#include "comms/wire.hpp"
#include "support/other_side.hpp"

namespace onemap {
namespace {

using namespace comms;
using sim::Datagram;
using Clock = std::chrono::steady_clock;

struct Victim {
  MemoryStore store{1u << 20};
  Pins pins;
  Node node;
  Guard guard;
  static NodeConfig node_config() {
    NodeConfig config;
    config.self = RobotId::from_name("honest");
    config.sealed = true;
    return config;
  }
  static GuardConfig guard_config() {
    GuardConfig config{node_config().self, 1, {}, TeamKey({1, 2, 3}), Identity(SecretSeed{1}), {}, {}, 64};
    config.random = [random = test::Random(5)](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    return config;
  }
  Victim() : node(node_config(), store), guard(guard_config(), node, pins) {}
  std::size_t answers() {
    std::size_t n = 0;
    OutgoingDatagram out;
    while (guard.next_outgoing(out)) ++n;
    return n;
  }
};

constexpr int kRuns = 50;

// The shortest of many short runs, so that others on the machine count least; ns a datagram, and how many were
// answered.
void measure(const char* name, std::size_t count, const std::function<const Datagram&(std::size_t)>& datagram,
             Victim& victim) {
  const Instant now{std::chrono::seconds(2)};
  double best = 1e30;
  std::size_t answers = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto begun = Clock::now();
    for (std::size_t i = 0; i < count; ++i) {
      const auto port = static_cast<std::uint16_t>(1000 + i % 60000);
      victim.guard.on_datagram(now, Endpoint::ipv4(10, 0, 0, 7, port), datagram(i));
    }
    best = std::min(
        best, std::chrono::duration<double, std::nano>(Clock::now() - begun).count() / static_cast<double>(count));
    answers += victim.answers();
  }
  fmt::print("{:<44} {:8.0f} ns {:12.0f} a second  answers {}\n", name, best, 1e9 / best, answers);
}

int run() {
  Victim victim;
  test::Random random(1);
  const auto garbage = [&](std::size_t size, int type) {
    Datagram bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    if (type < 0) return bytes;
    bytes[0] = sealed::kMagicAndVersion;
    bytes[1] = static_cast<std::uint8_t>(type);
    bytes[2] = bytes[3] = 0;
    return bytes;
  };
  const auto one = [&](const char* name, const Datagram& bytes, std::size_t count = 2'000) {
    measure(
        name, count, [&](std::size_t) -> const Datagram& { return bytes; }, victim);
  };
  one("random bytes, 1200", garbage(1200, -1));
  one("a plain datagram, 1192", Datagram(1192, 0xB1));
  one("a hello without the team's key, 1200", garbage(1200, 1));
  one("an answer without the team's key", garbage(sealed::kAnswerBytes, 2));
  one("a proof without the team's key", garbage(sealed::kProofBytes, 3));
  one("a cookie that nobody asked for", garbage(sealed::kCookieBytes, 4));
  one("frames of no session, 1200", garbage(1200, 5));
  one("a group datagram by a stranger, 1200", garbage(1200, 9));
  return 0;
}

}  // namespace
}  // namespace onemap

int main() { return onemap::run(); }
