#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

struct StampedPose {
  FrameTime time{};
  QuantizedPose T_robot_camera;
};
struct TrajectoryRecord {          // lane poses; consecutive batches
  std::vector<StampedPose> poses;  // at most 4096, times strictly increasing
};

std::vector<std::uint8_t> encode(const TrajectoryRecord& record);
Result<TrajectoryRecord> decode_trajectory(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
