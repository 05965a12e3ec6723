#pragma once
#include <cstdint>

#include "hal/base/ids.hpp"

namespace onemap::comms {

// What a robot says about itself, as it travels hop by hop through the team: the newest (incarnation, counter) wins.
struct RobotStatus {
  RobotId robot;
  std::uint64_t incarnation = 0;
  std::uint32_t counter = 0;
  std::uint64_t frontier_digest = 0;  // of what it holds
  std::uint64_t map_digest = 0;       // as given to Node::set_local_status
  std::uint8_t flags = 0;             // as given to Node::set_local_status
  bool operator==(const RobotStatus&) const = default;
};
inline constexpr std::uint8_t kStatusFinished = 1;  // this robot will write nothing more of its own camera

}  // namespace onemap::comms
