#pragma once
// The peer of hal/imaging's DepthRegistration: librealsense's alignment of depth to colour, written plainly after its
// published algorithm (src/proc/align.cpp): both corners of a depth pixel are moved, and the rectangle between them is
// filled with the nearest depth.
#include <algorithm>
#include <cstdint>
#include <span>

#include "hal/imaging/register_depth.hpp"

namespace onemap::test {

struct AlignPeer {
  hal::Intrinsics depth, colour;
  hal::imaging::ColourFromDepth pose;

  void apply(std::span<const std::uint16_t> from, std::span<std::uint16_t> to) const {
    std::fill(to.begin(), to.end(), std::uint16_t{0});
    for (int y = 0; y < depth.height; ++y)
      for (int x = 0; x < depth.width; ++x) {
        const std::uint16_t value = from[static_cast<std::size_t>(y * depth.width + x)];
        if (value == 0) continue;
        const float z = static_cast<float>(value) / static_cast<float>(depth.depth_scale);
        const Pixel first = moved(static_cast<float>(x) - 0.5f, static_cast<float>(y) - 0.5f, z);
        const Pixel last = moved(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, z);
        if (first.x < 0 || first.y < 0 || last.x >= colour.width || last.y >= colour.height) continue;
        for (int v = first.y; v <= last.y; ++v)
          for (int u = first.x; u <= last.x; ++u) {
            std::uint16_t& pixel = to[static_cast<std::size_t>(v * colour.width + u)];
            pixel = pixel != 0 ? std::min(pixel, value) : value;
          }
      }
  }

 private:
  struct Pixel {
    int x, y;
  };
  Pixel moved(float x, float y, float z) const {
    const float p[3] = {z * (x - f(depth.cx)) / f(depth.fx), z * (y - f(depth.cy)) / f(depth.fy), z};
    float q[3];
    for (std::size_t i = 0; i < 3; ++i)
      q[i] = f(pose.rotation[3 * i]) * p[0] + f(pose.rotation[3 * i + 1]) * p[1] + f(pose.rotation[3 * i + 2]) * p[2] +
             f(pose.translation_m[i]);
    return {static_cast<int>(q[0] / q[2] * f(colour.fx) + f(colour.cx) + 0.5f),
            static_cast<int>(q[1] / q[2] * f(colour.fy) + f(colour.cy) + 0.5f)};
  }
  static float f(double value) { return static_cast<float>(value); }
};

}  // namespace onemap::test
