#pragma once
#include <cstdint>
#include <string>

#include "hal/backends.hpp"

namespace onemap::hal::simulated {

enum class SceneName { living_room, office, storage, empty_hall, corridor, house, ring, blank_walls };

// A simulated camera's address, checked; defaults and ranges as in the public header.
struct Options {
  SceneName scene = SceneName::living_room;
  std::string scene_text;
  int robot = 1, robots = 3;
  std::uint64_t frames = 200, seed = 1;
  bool kinect_noise = true;
  double near_m = 0.5, far_m = 5.0;
  int width = 640, height = 480, fps = 30;
  int depth_late_ms = 0;
  std::uint64_t carried_at = 1'000'000;

  Intrinsics intrinsics() const;
  // Stamps start at a fixed epoch, each robot's 11 ms after the one before it: no two cameras are in step.
  FrameTime time(std::uint64_t frame) const;
};
Result<Options> parse_options(const CameraAddress& address);

}  // namespace onemap::hal::simulated
