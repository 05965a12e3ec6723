#pragma once
#include <array>
#include <bit>
#include <compare>
#include <cstdint>

namespace onemap::comms {

// Where a datagram comes from or goes to: an IPv6 address (IPv4 as ::ffff:a.b.c.d) and a port. The protocol only
// compares endpoints; text and sockets are comms/udp's.
struct Endpoint {
  std::array<std::uint8_t, 16> address{};
  std::uint16_t port = 0;
  constexpr bool operator==(const Endpoint& other) const { return (*this <=> other) == 0; }
  constexpr std::strong_ordering operator<=>(const Endpoint& other) const {  // in any order that stays the same
    using Halves = std::array<std::uint64_t, 2>;
    const auto halves = std::bit_cast<Halves>(address), others = std::bit_cast<Halves>(other.address);
    if (const auto order = halves[1] <=> others[1]; order != 0) return order;
    if (const auto order = halves[0] <=> others[0]; order != 0) return order;
    return port <=> other.port;
  }

  static constexpr Endpoint ipv4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d, std::uint16_t port) {
    return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, a, b, c, d}, port};
  }
  constexpr bool is_ipv4() const {
    for (std::size_t i = 0; i < 10; ++i)
      if (address[i] != 0) return false;
    return address[10] == 0xFF && address[11] == 0xFF;
  }
};

}  // namespace onemap::comms
