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
  static constexpr std::uint64_t kNever = 1'000'000;
  std::uint64_t carried_at = kNever;
  // Faults, by frame; each lasts for so many frames.
  std::uint64_t unplug_at = kNever, back_after = kNever;
  std::uint64_t freeze_at = kNever, black_at = kNever, saturate_at = kNever, no_depth_at = kNever;
  std::uint64_t time_back_at = kNever, fault_for = kNever;
  double fx_scale = 1;

  Intrinsics intrinsics() const;          // true
  Intrinsics claimed_intrinsics() const;  // what the camera says
  bool faulty(std::uint64_t since, std::uint64_t frame) const { return frame >= since && frame - since < fault_for; }
  // True, whatever the camera says. Stamps start at a fixed epoch, each robot's 11 ms after the one before it: no two
  // cameras are in step.
  FrameTime time(std::uint64_t frame) const;
};
Result<Options> parse_options(const CameraAddress& address);

}  // namespace onemap::hal::simulated
