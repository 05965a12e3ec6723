#pragma once
#include <array>
#include <bit>
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace onemap {

// Who a robot is: 16 opaque bytes, ordered byte by byte. Today they are the robot's name (at most 16 characters of
// A-Z a-z 0-9 _ . -), zero padded; an identity key's hash fits the same room.
struct RobotId {
  std::array<std::uint8_t, 16> bytes{};
  // Eight bytes at a time, in the order of single bytes: all that the exchange looks up is looked up by this.
  constexpr bool operator==(const RobotId& other) const {
    const auto halves = std::bit_cast<Halves>(bytes), others = std::bit_cast<Halves>(other.bytes);
    return halves[0] == others[0] && halves[1] == others[1];
  }
  constexpr std::strong_ordering operator<=>(const RobotId& other) const {
    const auto halves = std::bit_cast<Halves>(bytes), others = std::bit_cast<Halves>(other.bytes);
    if (halves[0] != others[0]) return most_significant_first(halves[0]) <=> most_significant_first(others[0]);
    return most_significant_first(halves[1]) <=> most_significant_first(others[1]);
  }

  static constexpr bool valid_name(std::string_view name) {
    if (name.empty() || name.size() > 16) return false;
    for (char c : name) {
      const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                        c == '-' || c == '.';
      if (!good) return false;
    }
    return name.front() != '.';
  }
  static RobotId from_name(std::string_view name) {
    RobotId id;
    for (std::size_t i = 0; i < name.size() && i < id.bytes.size(); ++i)
      id.bytes[i] = static_cast<std::uint8_t>(name[i]);
    return id;
  }
  // A valid name, then zeros to the end: what bytes from outside must be before anything is done with them.
  bool valid() const {
    const std::string text = name();
    for (std::size_t i = text.size(); i < bytes.size(); ++i)
      if (bytes[i] != 0) return false;
    return valid_name(text);
  }
  std::string name() const {
    std::string text;
    for (auto b : bytes) {
      if (b == 0) break;
      text.push_back(static_cast<char>(b));
    }
    return text;
  }

 private:
  using Halves = std::array<std::uint64_t, 2>;
  static constexpr std::uint64_t most_significant_first(std::uint64_t bytes) {
    return std::endian::native == std::endian::little ? __builtin_bswap64(bytes) : bytes;
  }
};

}  // namespace onemap
