#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

// Shapes that keys have, and what is done to their bytes.
namespace onemap::comms {

using Bytes = std::span<const std::uint8_t>;
using MutableBytes = std::span<std::uint8_t>;

void wipe(MutableBytes secret);                 // also where a compiler would leave it out
bool equal_in_constant_time(Bytes a, Bytes b);  // false when the lengths differ

// 32 bytes that nobody else may know: wiped when they go.
struct Secret32 {
  std::array<std::uint8_t, 32> bytes{};
  Secret32() = default;
  explicit Secret32(const std::array<std::uint8_t, 32>& from) : bytes(from) {}
  Secret32(const Secret32&) = default;
  Secret32& operator=(const Secret32&) = default;
  ~Secret32() { wipe(bytes); }
  bool operator==(const Secret32& other) const { return equal_in_constant_time(bytes, other.bytes); }
};
using TeamKey = Secret32;  // what every robot of a team knows, and nobody else

}  // namespace onemap::comms
