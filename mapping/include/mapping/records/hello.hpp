#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::mapping {

struct HelloRecord {   // lane control, first record of a robot
  std::string name;    // 1..16 characters
  std::string camera;  // 0..200 bytes without control characters, for people
  // An earlier life of this robot, all of whose records this one holds again (see comms: outlived); 0: none.
  std::uint64_t repeats = 0;
  std::uint32_t map_blocks = 0;  // as many this robot's global map can hold, 1 to 2^24; 0: not said
};

std::vector<std::uint8_t> encode(const HelloRecord& record);
Result<HelloRecord> decode_hello(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
