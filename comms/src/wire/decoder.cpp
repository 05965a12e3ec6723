#include <xxhash.h>

#include <bit>

#include "comms/wire.hpp"

namespace onemap::comms::wire {

namespace {
RobotId get_robot(ByteReader& in) {
  RobotId robot;
  get_bytes(in, robot.bytes);
  return robot;
}
LogId get_log(ByteReader& in) {
  LogId log;
  log.robot = get_robot(in);
  log.lane = in.get<std::uint8_t>();
  log.incarnation = in.get<std::uint64_t>();
  return log;
}

std::uint32_t fragment_size(std::uint32_t total, std::uint32_t fragment) {
  return std::min<std::uint32_t>(kFragmentBytes, total - fragment * static_cast<std::uint32_t>(kFragmentBytes));
}
}  // namespace

FrameType type_of(const Frame& frame) {
  constexpr std::array kTypes{FrameType::beacon,       FrameType::status, FrameType::have,
                              FrameType::have_request, FrameType::want,   FrameType::data,
                              FrameType::ping,         FrameType::pong,   FrameType::feedback,
                              FrameType::later_life,   FrameType::head,   FrameType::mass};  // in the order of Frame
  static_assert(kTypes.size() == std::variant_size_v<Frame>);
  return kTypes[frame.index()];
}

std::uint64_t body_hash(std::uint16_t kind, std::span<const std::uint8_t> payload) {
  return XXH3_64bits_withSeed(payload.data(), payload.size(), kind);
}

void Decoder::clear() {
  frames_.clear();
  robots_.clear();
  have_.clear();
  want_.clear();
  robots_.reserve(kMaxFramesBytes / kStatusEntryBytes);
  have_.reserve(kMaxFramesBytes / kHaveEntryBytes);
  want_.reserve(kMaxFramesBytes / kWantEntryBytes);
}

Refusal Decoder::decode(const Header& header, std::span<const std::uint8_t> frames) {
  clear();
  header_ = header;
  return decode_frames(frames);
}

Refusal Decoder::decode(std::span<const std::uint8_t> datagram) {
  clear();
  const Refusal verdict = read_header(datagram, header_);
  if (verdict != Refusal::count) return verdict;
  return decode_frames(datagram.subspan(kHeaderBytes));
}

Refusal Decoder::decode_frames(std::span<const std::uint8_t> frames) {
  constexpr auto kLastKnown = static_cast<std::uint8_t>(FrameType::mass);
  bad_robot_id_ = false;
  ByteReader in(frames);
  while (in.remaining() > 0) {
    const auto type = in.get<std::uint8_t>();
    const auto body = in.bytes(in.get<std::uint16_t>());
    if (!in.ok()) return Refusal::bad_frame;
    if (type <= kLastKnown && !decode_frame(type, body))
      return bad_robot_id_ ? Refusal::bad_robot_id : Refusal::bad_frame;
  }
  return Refusal::count;
}

// An honest robot lets no such id in, so it has none to pass on: the whole datagram is void.
bool Decoder::valid(const RobotId& robot) {
  if (robot.valid()) return true;
  bad_robot_id_ = true;
  return false;
}
bool Decoder::valid(const LogId& log) { return log.lane < kLaneCount && log.incarnation != 0 && valid(log.robot); }

bool Decoder::decode_frame(std::uint8_t type, std::span<const std::uint8_t> body) {
  ByteReader in(body);
  switch (static_cast<FrameType>(type)) {
    case FrameType::beacon: {
      Beacon beacon;
      beacon.robot = get_robot(in);
      beacon.frontier_digest = in.get<std::uint64_t>();
      beacon.map_digest = in.get<std::uint64_t>();
      beacon.status_counter = in.get<std::uint32_t>();
      beacon.flags = in.get<std::uint8_t>();
      frames_.emplace_back(beacon);
      return in.done() && valid(beacon.robot);
    }
    case FrameType::status:
      return decode_status(body);
    case FrameType::have:
      return decode_have(body);
    case FrameType::have_request:
      frames_.emplace_back(HaveRequest{});
      return in.done();
    case FrameType::want:
      return decode_want(body);
    case FrameType::data:
      return decode_data(body);
    case FrameType::ping:
      frames_.emplace_back(Ping{in.get<std::uint32_t>()});
      return in.done();
    case FrameType::pong:
      frames_.emplace_back(Pong{in.get<std::uint32_t>()});
      return in.done();
    case FrameType::feedback: {
      Feedback feedback;
      feedback.highest = in.get<std::uint32_t>();
      feedback.received = in.get<std::uint32_t>();
      feedback.clock_us = in.get<std::uint32_t>();
      feedback.delay_us = in.get<std::uint32_t>();
      frames_.emplace_back(feedback);
      return in.done();
    }
    case FrameType::head:
      return decode_head(body);
    case FrameType::later_life: {
      LaterLife later;
      later.robot = get_robot(in);
      later.incarnation = in.get<std::uint64_t>();
      frames_.emplace_back(later);
      return in.done() && later.incarnation != 0 && valid(later.robot);
    }
    case FrameType::mass:
      return decode_mass(body);
  }
  return false;
}

bool Decoder::decode_status(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const std::size_t first = robots_.size();
  while (in.remaining() > 0) {
    RobotStatus status;
    status.robot = get_robot(in);
    status.incarnation = in.get<std::uint64_t>();
    status.counter = in.get<std::uint32_t>();
    status.frontier_digest = in.get<std::uint64_t>();
    status.map_digest = in.get<std::uint64_t>();
    status.flags = in.get<std::uint8_t>();
    if (!in.ok() || status.incarnation == 0 || !valid(status.robot)) return false;
    robots_.push_back(status);
  }
  frames_.emplace_back(Status{std::span(robots_).subspan(first)});
  return in.ok();
}

bool Decoder::decode_have(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const std::size_t first = have_.size();
  const auto frontier_digest = in.get<std::uint64_t>();
  while (in.remaining() > 0) {
    HaveEntry entry;
    entry.log = get_log(in);
    entry.count = in.get<std::uint32_t>();
    if (!in.ok() || entry.count == 0 || !valid(entry.log)) return false;
    have_.push_back(entry);
  }
  frames_.emplace_back(Have{frontier_digest, std::span(have_).subspan(first)});
  return in.ok();
}

bool Decoder::decode_want(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const std::size_t first = want_.size();
  const auto credit = in.get<std::uint32_t>();
  while (in.remaining() > 0) {
    WantEntry entry;
    entry.id.log = get_log(in);
    entry.id.seq = in.get<std::uint32_t>();
    entry.first = in.get<std::uint16_t>();
    entry.count = in.get<std::uint16_t>();
    if (!in.ok() || entry.count == 0 || !valid(entry.id.log)) return false;
    want_.push_back(entry);
  }
  frames_.emplace_back(Want{credit, std::span(want_).subspan(first)});
  return in.ok();
}

bool Decoder::decode_mass(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  Mass mass;
  mass.heard = in.get<std::uint16_t>();
  mass.neighbours = in.get<std::uint8_t>();
  mass.round = in.get<std::uint64_t>();
  mass.clock_ns = in.get<std::int64_t>();
  mass.has_amounts = in.remaining() > 0;
  for (comms::Mass& given : mass.given) {
    if (!mass.has_amounts) break;
    given.y = std::bit_cast<double>(in.get<std::uint64_t>());
    given.z = std::bit_cast<double>(in.get<std::uint64_t>());
  }
  frames_.emplace_back(mass);
  return in.done() && (mass.round != 0 || !mass.has_amounts);
}

bool Decoder::decode_data(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  Data data;
  data.id.log = get_log(in);
  data.id.seq = in.get<std::uint32_t>();
  data.kind = in.get<std::uint16_t>();
  data.hops = in.get<std::uint8_t>();
  data.total_bytes = in.get<std::uint32_t>();
  data.body_hash = in.get<std::uint64_t>();
  data.fragment = in.get<std::uint16_t>();
  if (!in.ok() || !valid(data.id.log) || data.total_bytes > kMaxPayloadBytes) return false;
  if (data.total_bytes < kSealBytes) return false;
  if (data.fragment >= fragments_of(data.total_bytes)) return false;
  data.bytes = in.bytes(fragment_size(data.total_bytes, data.fragment));
  frames_.emplace_back(data);
  return in.done();
}

bool Decoder::decode_head(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  Head head;
  RecordHead& record = head.record;
  record.id.log = get_log(in);
  record.id.seq = in.get<std::uint32_t>();
  record.kind = in.get<std::uint16_t>();
  head.hops = in.get<std::uint8_t>();
  record.bytes = in.get<std::uint32_t>();
  get_bytes(in, record.body);
  get_bytes(in, record.previous);
  record.replaces = in.get<std::uint32_t>();
  get_bytes(in, head.signature);
  RecordHead& by = head.by.head;
  by.id = {record.id.log, in.get<std::uint32_t>()};
  by.kind = record.kind;
  by.bytes = in.get<std::uint32_t>();
  get_bytes(in, by.body);
  get_bytes(in, by.previous);
  by.replaces = record.id.seq;
  get_bytes(in, head.by.signature);
  frames_.emplace_back(head);
  return in.done() && valid(record.id.log) && std::max(record.bytes, by.bytes) <= kMaxRecordBytes &&
         by.id.seq > record.id.seq;
}

}  // namespace onemap::comms::wire
