#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "hal/frame.hpp"

namespace onemap::hal::imaging {

// A rigid motion: p_colour = R p_depth + t, from the depth camera's frame to the colour camera's (x right, y down, z
// forward, metres).
struct ColourFromDepth {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row by row
  std::array<double, 3> translation_m{};
  bool operator==(const ColourFromDepth&) const = default;
};

// Moves a depth image onto the colour image's pixels, for cameras that do not do it themselves. Each reading covers
// what its pixel covers in the colour image, so that a finer colour image has no holes, and where several readings
// fall on a pixel the nearest is kept: what the colour camera cannot see behind it gives no depth there.
class DepthRegistration {
 public:
  // Both cameras' lenses; their depth_scale say the units of what is read and of what is written; offset_m is added to
  // each reading. Takes all memory.
  DepthRegistration(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose,
                    double offset_m = 0);
  ~DepthRegistration();

  struct Counts {
    std::uint64_t readings = 0;  // of the depth image
    std::uint64_t outside =
        0;  // of them, those that give the colour image nothing: beside it, behind it, too far, between its pixels
    void add_unseen(std::span<const std::uint16_t> row);  // of which colour sees nothing
  };
  // depth: as the depth camera's size, 0 = no reading. registered: as the colour image's size, all of it written.
  Counts apply(std::span<const std::uint16_t> depth, std::span<std::uint16_t> registered);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace onemap::hal::imaging
