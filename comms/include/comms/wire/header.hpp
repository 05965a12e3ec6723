#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "comms/counters.hpp"
#include "comms/datagram_port.hpp"

// What stands before the frames of a plain datagram (comms/PROTOCOL.md). In a team with a key it never leaves the
// robot: a Guard seals the frames under a header of its own.
namespace onemap::comms::wire {

inline constexpr std::uint8_t kMagicAndVersion = 0xB1;  // high nibble: ours; low nibble: major version
inline constexpr std::size_t kHeaderBytes = 24;
inline constexpr std::size_t kMaxFramesBytes = 1168;       // what a session's overhead of 32 bytes leaves
inline constexpr std::size_t kMaxGroupFramesBytes = 1140;  // what a sealed group datagram's 60 leave
inline constexpr std::uint64_t kFirstBadIncarnation = std::uint64_t{1}
                                                      << 63;  // no life has this number or a greater one
constexpr bool is_life(std::uint64_t incarnation) { return incarnation != 0 && incarnation < kFirstBadIncarnation; }
constexpr std::uint32_t next_counter(std::uint32_t counter) { return counter == 0xFFFFFFFF ? 1 : counter + 1; }

enum class DatagramType : std::uint8_t { unicast = 8, group = 9 };

struct Header {
  DatagramType type = DatagramType::unicast;
  std::uint64_t sender = 0;    // the sender's incarnation
  std::uint64_t receiver = 0;  // the receiver's incarnation as the sender knows it; 0: not known, or a group
  // 1, 2, 3 ... by the sender, one count for each destination; after 2^32 - 1 comes 1.
  std::uint32_t counter = 0;
  bool operator==(const Header&) const = default;
};

// Reads the header of a datagram and looks at its size: Refusal::count when it is good, else why not.
Refusal read_header(std::span<const std::uint8_t> datagram, Header& header);
void write_header(std::span<std::uint8_t, kMaxDatagramBytes> datagram, const Header& header);

}  // namespace onemap::comms::wire
