#pragma once
#include <cstdint>
#include <span>

#include "hal/base/time.hpp"

namespace onemap::hal {

// Pinhole intrinsics of the colour image, with OpenCV's five distortion coefficients (k1 k2 p1 p2 k3); depth is
// registered to colour, pixel for pixel. Pixel centres are at integer coordinates.
struct Intrinsics {
  int width = 640, height = 480;                      // pixels
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  // pixels
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;      // dimensionless
  double depth_scale = 5000;                          // depth value / depth_scale = metres along the optical axis

  bool operator==(const Intrinsics&) const = default;
};

// A view of one RGB-D frame; the memory belongs to a FramePool slot. rgb: height x width x 3 bytes, row by row; depth:
// height x width values, 0 = no reading. Camera frame: x right, y down, z forward.
struct FrameView {
  FrameTime colour_time{};  // the frame's own time: poses belong to it
  FrameTime depth_time{};   // when depth was measured; equal to colour_time where the camera does not tell
  std::uint64_t index = 0;  // number of the frame in its stream, from 0, gaps where frames were skipped
  const Intrinsics* intrinsics = nullptr;
  std::span<const std::uint8_t> rgb;
  std::span<const std::uint16_t> depth;
};

}  // namespace onemap::hal
