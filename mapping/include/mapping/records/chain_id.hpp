#pragma once
#include <cstdint>

#include "hal/base/ids.hpp"

namespace onemap::mapping {

// One life of one robot: odometry without a gap. A robot that was switched off and on goes on as another chain.
struct ChainId {
  RobotId robot;
  std::uint64_t incarnation = 0;
  auto operator<=>(const ChainId&) const = default;
};

}  // namespace onemap::mapping
