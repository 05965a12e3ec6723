#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

struct SolvedRobot {
  RobotId robot;
  QuantizedPose T_global_robot;
};
struct SolutionRecord {             // lane poses; of the elected robot; the last one counts
  RobotId reference;                // the global frame is this robot's own frame: its pose is the identity
  std::vector<SolvedRobot> robots;  // in the map, sorted by id, the reference among them; at most 1024
  std::uint32_t links_used = 0;
};

std::vector<std::uint8_t> encode(const SolutionRecord& record);
Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
