#pragma once
#include <cstdint>
#include <span>

#include "comms/traffic.hpp"

namespace onemap::comms {

// Adds a datagram of `on_wire` bytes that carries these well-formed frames.
void count_traffic(Traffic::Way& way, std::span<const std::uint8_t> frames, std::size_t on_wire);

}  // namespace onemap::comms
