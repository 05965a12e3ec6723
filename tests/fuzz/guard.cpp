#include "fuzz/guard.hpp"

#include <cstdlib>

#include "comms/memory_store.hpp"
#include "comms/wire/header.hpp"
#include "session/group_seal.hpp"
#include "support/other_side.hpp"

namespace onemap::fuzz {

namespace {
using namespace comms;
using sim::Datagram;

class Script {
 public:
  Script(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}
  bool over() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t first = rest_[0];
    rest_ = rest_.subspan(1);
    return first;
  }
  Datagram some(std::size_t most) {
    const std::size_t size = std::min<std::size_t>(rest_.size(), std::min<std::size_t>(most, byte() * 5u));
    const auto part = rest_.first(std::min(size, rest_.size()));
    rest_ = rest_.subspan(part.size());
    return {part.begin(), part.end()};
  }

 private:
  Bytes rest_;
};

struct World {
  World() : node(node_config(), store), guard(guard_config(), node, pins), other(TeamKey({1, 2, 3})) {
    guard.on_timer(now);
    drain();
    sent = came = 0;
  }
  static NodeConfig node_config() {
    NodeConfig config;
    config.self = RobotId::from_name("honest");
    config.sealed = true;
    return config;
  }
  static GuardConfig guard_config() {
    const NodeConfig node = node_config();
    GuardConfig config{node.self, 1, {}, TeamKey({1, 2, 3}), Identity(SecretSeed{1}), {}, {}, 64};
    config.random = [random = test::Random(5)](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    return config;
  }
  void drain() {
    OutgoingDatagram out;
    while (guard.next_outgoing(out)) {
      if (out.size > kMaxDatagramBytes) std::abort();
      sent += out.size;
      last.assign(out.bytes().begin(), out.bytes().end());
    }
  }
  void hear(const Datagram& bytes) {
    came += bytes.size();
    guard.on_datagram(now, from, bytes);
    drain();
    if (guard.sessions() == 0 && sent > came) std::abort();  // to whoever has proved nothing
  }

  Instant now{std::chrono::seconds(1)};
  Endpoint from = Endpoint::ipv4(10, 0, 0, 2, 4600);
  MemoryStore store{1u << 20};
  Pins pins;
  Node node;
  Guard guard;
  sim::OtherSide other;
  bool began = false;
  Datagram last;
  std::size_t sent = 0, came = 0;
};

// What is changed of a datagram before it goes: some bytes, by what the script says.
void change(Datagram& bytes, Script& script) {
  for (int n = script.byte() % 4; n > 0 && !bytes.empty(); --n) {
    const std::size_t at = (std::size_t{script.byte()} << 8 | script.byte()) % bytes.size();
    bytes[at] ^= script.byte();
  }
  if (script.byte() % 16 == 1 && !bytes.empty()) bytes.resize(bytes.size() - 1 - script.byte() % bytes.size());
}

void put_mac(Datagram& bytes, std::size_t at, const TeamSecrets& team) {
  if (bytes.size() < at + sealed::kMacBytes) return;
  const Mac mac = mac_of(team.mac.bytes, Bytes(bytes).first(at));
  std::copy(mac.begin(), mac.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

void hello(World& world, Script& script) {
  Datagram bytes = world.other.hello(world.now);
  world.began = true;
  change(bytes, script);
  if (script.byte() % 2 == 0) put_mac(bytes, sealed::kHelloMac1At, world.other.team());
  world.hear(bytes);
}

void proof(World& world, Script& script) {
  if (!world.began || world.last.size() != sealed::kAnswerBytes) return;
  Datagram bytes = world.other.proof(world.now, world.last);
  if (bytes.empty()) return;
  change(bytes, script);
  if (script.byte() % 2 == 0) put_mac(bytes, sealed::kProofBytes - sealed::kMacBytes, world.other.team());
  world.hear(bytes);
}

void frames(World& world, Script& script) {
  if (!world.began || !world.other.initiation().made()) return;
  Datagram bytes = world.other.sealed(script.some(1168), script.byte());
  change(bytes, script);
  world.hear(bytes);
}

void own_word(World& world, Script& script) {
  if (!world.began || !world.other.initiation().made()) return;
  Datagram bytes(sealed::kOwnBytes);
  world.other.session().say(bytes, static_cast<sealed::Word>(script.byte() % 5), script.byte());
  change(bytes, script);
  world.hear(bytes);
}

void group(World& world, Script& script) {
  GroupSeal seal(world.other.team().group, script.byte());
  const Datagram plain = script.some(wire::kMaxGroupFramesBytes);
  OutgoingDatagram datagram;
  std::copy(plain.begin(), plain.end(), datagram.buffer.begin() + wire::kHeaderBytes);
  datagram.size = wire::kHeaderBytes + plain.size();
  seal.seal(datagram, world.other.random());
  Datagram bytes(datagram.bytes().begin(), datagram.bytes().end());
  change(bytes, script);
  world.came += kMaxDatagramBytes;  // it is worth a hello
  world.hear(bytes);
}
}  // namespace

void fuzz_guard(const std::uint8_t* data, std::size_t size) {
  World world;
  Script script(data, size);
  for (int steps = 0; !script.over() && steps < 200; ++steps) {
    switch (script.byte() % 8) {
      case 0:
        world.hear(script.some(1300));
        break;
      case 1:
        hello(world, script);
        break;
      case 2:
        proof(world, script);
        break;
      case 3:
        frames(world, script);
        break;
      case 4:
        own_word(world, script);
        break;
      case 5:
        group(world, script);
        break;
      case 6:
        world.from.port = static_cast<std::uint16_t>(4600 + script.byte() % 4);
        break;
      default:
        world.now += std::chrono::milliseconds(script.byte() * 50);
        world.came += 2 * kMaxDatagramBytes;  // hellos that the node asks for
        world.guard.on_timer(world.now);
        world.drain();
    }
  }
}

}  // namespace onemap::fuzz
