#include <algorithm>
#include <bit>

#include "comms/wire.hpp"

namespace onemap::comms::wire {

Encoder::Encoder(std::span<std::uint8_t, kMaxDatagramBytes> buffer, const Header& header)
    : buffer_(buffer), max_frames_(header.type == DatagramType::group ? kMaxGroupFramesBytes : kMaxFramesBytes) {
  write_header(buffer, header);
}

void Encoder::put(const RobotId& robot) { put(robot.bytes); }
void Encoder::put(const LogId& log) {
  put(log.robot);
  put(log.lane);
  put(log.incarnation);
}

bool Encoder::open(FrameType type, std::size_t body_bytes) {
  if (kFrameHeadBytes + body_bytes > room()) return false;
  put(static_cast<std::uint8_t>(type));
  put(static_cast<std::uint16_t>(body_bytes));
  return true;
}

std::size_t Encoder::entries_that_fit(std::size_t fixed, std::size_t each, std::size_t wanted) const {
  if (room() < kFrameHeadBytes + fixed) return 0;
  return std::min(wanted, (room() - kFrameHeadBytes - fixed) / each);
}

bool Encoder::beacon(const Beacon& beacon) {
  if (!open(FrameType::beacon, kBeaconBytes)) return false;
  put(beacon.robot);
  put(beacon.frontier_digest);
  put(beacon.map_digest);
  put(beacon.status_counter);
  put(beacon.flags);
  return true;
}

std::size_t Encoder::status(std::span<const RobotStatus> robots) {
  const std::size_t n = entries_that_fit(0, kStatusEntryBytes, robots.size());
  if (n == 0 || !open(FrameType::status, n * kStatusEntryBytes)) return 0;
  for (const RobotStatus& status : robots.first(n)) {
    put(status.robot);
    put(status.incarnation);
    put(status.counter);
    put(status.frontier_digest);
    put(status.map_digest);
    put(status.flags);
  }
  return n;
}

std::size_t Encoder::have(std::uint64_t frontier_digest, std::span<const HaveEntry> entries) {
  const std::size_t n = entries_that_fit(kHaveFixedBytes, kHaveEntryBytes, entries.size());
  if (n == 0 || !open(FrameType::have, kHaveFixedBytes + n * kHaveEntryBytes)) return 0;
  put(frontier_digest);
  for (const HaveEntry& entry : entries.first(n)) {
    put(entry.log);
    put(entry.count);
  }
  return n;
}

bool Encoder::have_request() { return open(FrameType::have_request, 0); }

std::size_t Encoder::want(std::uint32_t credit_bytes, std::span<const WantEntry> entries) {
  const std::size_t n = entries_that_fit(kWantFixedBytes, kWantEntryBytes, entries.size());
  if (n == 0 || !open(FrameType::want, kWantFixedBytes + n * kWantEntryBytes)) return 0;
  put(credit_bytes);
  for (const WantEntry& entry : entries.first(n)) {
    put(entry.id.log);
    put(entry.id.seq);
    put(entry.first);
    put(entry.count);
  }
  return n;
}

bool Encoder::data(const Data& data) {
  if (!open(FrameType::data, kDataFixedBytes + data.bytes.size())) return false;
  put(data.id.log);
  put(data.id.seq);
  put(data.kind);
  put(data.hops);
  put(data.total_bytes);
  put(data.body_hash);
  put(data.fragment);
  std::copy(data.bytes.begin(), data.bytes.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += data.bytes.size();
  return true;
}

bool Encoder::head(const Head& head) {
  if (!open(FrameType::head, kHeadFrameBytes)) return false;
  const RecordHead& record = head.record;
  put(record.id.log);
  put(record.id.seq);
  put(record.kind);
  put(head.hops);
  put(record.bytes);
  put(record.body);
  put(record.previous);
  put(record.replaces);
  put(head.signature);
  const RecordHead& by = head.by.head;
  put(by.id.seq);
  put(by.bytes);
  put(by.body);
  put(by.previous);
  put(head.by.signature);
  return true;
}

bool Encoder::ping(std::uint32_t token) {
  if (!open(FrameType::ping, sizeof token)) return false;
  put(token);
  return true;
}

bool Encoder::pong(std::uint32_t token) {
  if (!open(FrameType::pong, sizeof token)) return false;
  put(token);
  return true;
}

bool Encoder::feedback(const Feedback& feedback) {
  if (!open(FrameType::feedback, kFeedbackBytes)) return false;
  put(feedback.highest);
  put(feedback.received);
  put(feedback.clock_us);
  put(feedback.delay_us);
  return true;
}

bool Encoder::later_life(const LaterLife& later) {
  if (!open(FrameType::later_life, kLaterLifeBytes)) return false;
  put(later.robot);
  put(later.incarnation);
  return true;
}

bool Encoder::mass(const Mass& mass) {
  if (!open(FrameType::mass, kMassFixedBytes + (mass.has_amounts ? kMassAmountsBytes : 0))) return false;
  put(mass.heard);
  put(mass.neighbours);
  put(mass.round);
  put(mass.clock_ns);
  for (const comms::Mass& given : mass.given) {
    if (!mass.has_amounts) break;
    put(std::bit_cast<std::uint64_t>(given.y));
    put(std::bit_cast<std::uint64_t>(given.z));
  }
  return true;
}

}  // namespace onemap::comms::wire
