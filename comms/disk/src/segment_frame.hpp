#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/base/record.hpp"

// How a record lies in a segment file (comms/PROTOCOL.md, "On the disk"): magic u32, length u32, XXH3-64 of what
// follows with the segment's number as the seed, head, body, zeros up to a multiple of 16.
namespace onemap::comms::segment {

inline constexpr std::size_t kPrefixBytes = 16, kHeadBytes = 168, kFixedBytes = kPrefixBytes + kHeadBytes;
inline constexpr std::size_t kAlign = 16;
inline constexpr std::size_t kMaxFrameBytes = (kFixedBytes + kMaxRecordBytes + kAlign - 1) / kAlign * kAlign;

constexpr std::size_t frame_bytes(std::size_t body_bytes) {
  return (kFixedBytes + body_bytes + kAlign - 1) / kAlign * kAlign;
}
// Replaces what is in `out`.
void write_frame(const Record& record, std::uint32_t segment, std::vector<std::uint8_t>& out);

// What the first kFixedBytes of a frame say; nothing: they are no frame's. Not yet held against the checksum.
struct Head {
  RecordId id;
  std::uint16_t kind = 0;
  Seal seal;
  std::uint32_t bytes = 0;  // of the body, as its author wrote it
  bool dropped = false;     // it is not here
  std::array<std::uint8_t, 32> digest{};
  std::size_t body_here() const { return dropped ? 0 : bytes; }
};
std::optional<Head> read_head(std::span<const std::uint8_t> bytes);
// The whole frame (frame_bytes of them) is what was written into this segment.
bool is_whole(std::span<const std::uint8_t> frame, std::uint32_t segment);

std::string name_of(std::uint32_t segment);                       // segment-0000002a
std::optional<std::uint32_t> number_of(const std::string& name);  // nothing: no segment's name

}  // namespace onemap::comms::segment
