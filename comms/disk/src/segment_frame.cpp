#include "segment_frame.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <charconv>

#include "comms/record_head.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms::segment {

namespace {
constexpr std::uint32_t kMagic = 0x32474C4F;  // "OLG2"
constexpr std::string_view kName = "segment-";

std::uint64_t sum_of(std::span<const std::uint8_t> content, std::uint32_t segment) {
  return XXH3_64bits_withSeed(content.data(), content.size(), segment);
}
}  // namespace

void write_frame(const Record& record, std::uint32_t segment, std::vector<std::uint8_t>& out) {
  const RecordHead head = head_of(record);
  out.clear();
  ByteWriter bytes(out);
  bytes.put(kMagic);
  bytes.put(static_cast<std::uint32_t>(kHeadBytes + record.body.size()));
  bytes.put(std::uint64_t{0});
  bytes.bytes(head.id.log.robot.bytes);
  bytes.put(head.id.log.lane);
  bytes.put(head.id.log.incarnation);
  bytes.put(head.id.seq);
  bytes.put(head.kind);
  bytes.put(static_cast<std::uint8_t>(record.dropped ? 1 : 0));
  bytes.put(head.bytes);
  bytes.bytes(head.body);
  bytes.bytes(record.seal.previous);
  bytes.put(record.seal.replaces);
  bytes.bytes(record.seal.signature);
  bytes.bytes(record.body);
  put_little_endian(out.data() + 8, sum_of(std::span(out).subspan(kPrefixBytes), segment));
  out.resize(frame_bytes(record.body.size()));
}

std::optional<Head> read_head(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kFixedBytes) return std::nullopt;
  ByteReader in(bytes);
  if (in.get<std::uint32_t>() != kMagic) return std::nullopt;
  const auto length = in.get<std::uint32_t>();
  in.get<std::uint64_t>();
  Head head;
  get_bytes(in, head.id.log.robot.bytes);
  head.id.log.lane = in.get<std::uint8_t>();
  head.id.log.incarnation = in.get<std::uint64_t>();
  head.id.seq = in.get<std::uint32_t>();
  head.kind = in.get<std::uint16_t>();
  const auto flags = in.get<std::uint8_t>();
  head.dropped = flags == 1;
  head.bytes = in.get<std::uint32_t>();
  get_bytes(in, head.digest);
  get_bytes(in, head.seal.previous);
  head.seal.replaces = in.get<std::uint32_t>();
  get_bytes(in, head.seal.signature);
  const bool good = flags <= 1 && head.bytes <= kMaxRecordBytes && length == kHeadBytes + head.body_here() &&
                    head.id.log.lane < kLaneCount && head.id.log.robot.valid();
  return good ? std::optional(head) : std::nullopt;
}

bool is_whole(std::span<const std::uint8_t> frame, std::uint32_t segment) {
  ByteReader in(frame);
  in.get<std::uint32_t>();
  const auto length = in.get<std::uint32_t>();
  const auto sum = in.get<std::uint64_t>();
  if (frame.size() < kPrefixBytes + length) return false;
  return sum == sum_of(frame.subspan(kPrefixBytes, length), segment);
}

std::string name_of(std::uint32_t segment) { return fmt::format("{}{:08x}", kName, segment); }

std::optional<std::uint32_t> number_of(const std::string& name) {
  if (name.size() != kName.size() + 8 || !name.starts_with(kName)) return std::nullopt;
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + kName.size(), name.data() + name.size(), number, 16);
  const bool good = error == std::errc{} && end == name.data() + name.size() && name_of(number) == name;
  return good ? std::optional(number) : std::nullopt;
}

}  // namespace onemap::comms::segment
