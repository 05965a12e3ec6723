#include <algorithm>
#include <array>

#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/wire.hpp"
#include "fuzz/expect.hpp"
#include "fuzz/targets.hpp"

namespace onemap::fuzz {

namespace {
using namespace comms;

// A datagram that is refused gives nothing; one that is good is within its bounds, in every frame.
void look_at(Bytes bytes) {
  wire::Decoder decoder;
  if (decoder.decode(bytes) != Refusal::count) return;
  ONEMAP_FUZZ_EXPECT(bytes.size() <= kMaxDatagramBytes);
  ONEMAP_FUZZ_EXPECT(wire::is_life(decoder.header().sender) && decoder.header().counter != 0);
  for (const wire::Frame& frame : decoder.frames()) {
    if (const auto* data = std::get_if<wire::Data>(&frame)) {
      ONEMAP_FUZZ_EXPECT(data->total_bytes <= kMaxRecordBytes + kSealBytes);
      ONEMAP_FUZZ_EXPECT(data->fragment * wire::kFragmentBytes + data->bytes.size() <= data->total_bytes);
      ONEMAP_FUZZ_EXPECT(data->id.log.robot.valid() && data->id.log.lane < kLaneCount);
    }
    if (const auto* head = std::get_if<wire::Head>(&frame))
      ONEMAP_FUZZ_EXPECT(head->record.bytes <= kMaxRecordBytes && head->record.id.log.robot.valid());
    if (const auto* have = std::get_if<wire::Have>(&frame))
      for (const auto& entry : have->entries) ONEMAP_FUZZ_EXPECT(entry.log.robot.valid() && entry.count > 0);
    if (const auto* want = std::get_if<wire::Want>(&frame))
      for (const auto& entry : want->entries) ONEMAP_FUZZ_EXPECT(entry.id.log.robot.valid() && entry.count > 0);
    if (const auto* status = std::get_if<wire::Status>(&frame))
      for (const auto& robot : status->robots) ONEMAP_FUZZ_EXPECT(robot.robot.valid() && robot.incarnation != 0);
  }
}

std::vector<std::uint8_t> with_header(const wire::Header& header) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  wire::write_header(buffer, header);
  return {buffer.begin(), buffer.begin() + wire::kHeaderBytes};
}
}  // namespace

void datagram(Bytes input) { look_at(input); }

void frame(Bytes input) {
  if (input.empty()) return;
  auto bytes = with_header({wire::DatagramType::unicast, 5, 7, 1});
  const Bytes body = input.subspan(1);
  bytes.push_back(input[0]);
  bytes.push_back(static_cast<std::uint8_t>(body.size()));
  bytes.push_back(static_cast<std::uint8_t>(body.size() >> 8));
  bytes.insert(bytes.end(), body.begin(), body.end());
  look_at(bytes);
}

// Before each: how long it is, from which of three addresses it comes, how many milliseconds go by before.
void node(Bytes input) {
  MemoryStore store(1u << 20);
  NodeConfig config;
  config.self = RobotId::from_name("self");
  config.incarnation = 7;
  config.identity = Identity(SecretSeed{1});
  Node robot(std::move(config), store);
  Instant now{std::chrono::seconds(1)};
  ONEMAP_FUZZ_EXPECT(robot.append(now, 1, 1, {1, 2, 3}).ok());
  std::size_t in = 0, out = 0, applied = 0;
  for (int count = 0; count < 64 && input.size() > 3; ++count) {
    const std::size_t size = std::min<std::size_t>(input[0], input.size() - 3);
    const Endpoint from = Endpoint::ipv4(10, 0, 0, static_cast<std::uint8_t>(input[1] % 3), 7000);
    now += std::chrono::milliseconds(input[2]);
    robot.on_datagram(now, from, input.subspan(3, size));
    in += size;
    if (robot.next_deadline() <= now) robot.on_timer(now);
    OutgoingDatagram datagram;
    while (robot.next_outgoing(datagram)) {
      ONEMAP_FUZZ_EXPECT(datagram.size <= kMaxDatagramBytes);
      look_at(datagram.bytes());
      ONEMAP_FUZZ_EXPECT((out += datagram.size) < 1'000'000 + 3'000 * (in + 1));
    }
    input = input.subspan(3 + size);
  }
  std::shared_ptr<const Record> record;
  while (robot.next_applied(record)) ++applied;
  ONEMAP_FUZZ_EXPECT(digest(robot.frontier()) == robot.frontier_digest());
  std::size_t held = 0;
  for (const auto& [log, records] : robot.frontier()) held += records;
  ONEMAP_FUZZ_EXPECT(held == applied);
}

}  // namespace onemap::fuzz
