#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "hal/base/result.hpp"
#include "mapping/team/floor_plan.hpp"
#include "mapping/team/map_up.hpp"

namespace onemap::mapping {

struct SurveyConfig {
  FreeSpaceConfig space;
  FloorPlanConfig plan;
  // Of more keyframes than these every second, third, ... is taken, so that a plan of whatever map takes seconds.
  std::size_t most_keyframes = 2000;
};

struct Survey {
  FloorPlan plan;
  Pose T_level_map;  // z up, floor at 0; the plan is in this frame
  FreeSpaceCounters space;
  std::size_t blocks = 0;              // of the free space, in use
  std::size_t keyframes_left_out = 0;  // beyond most_keyframes
  std::size_t keyframes_malformed = 0;
};

// The floor plan of a map from its keyframes: finds up and the floor in some of them, carves free space by all, looks
// at it from above. up: the map's, where it is known. One keyframe is decoded at a time. Pure; the order of the
// keyframes does not matter for what is carved, and little for the frame (which keyframes are looked at): give them
// sorted. The error says what the plan is lacking, or that stop(), which is asked before each keyframe, said true.
Result<Survey> survey(
    std::span<const PlacedKeyframe> keyframes, const SurveyConfig& config,
    const std::optional<Vector3f>& up = std::nullopt, const std::function<bool()>& stop = [] { return false; });

}  // namespace onemap::mapping
