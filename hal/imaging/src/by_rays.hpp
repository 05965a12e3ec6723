#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "footprints.hpp"
#include "hal/imaging/register_depth.hpp"

namespace onemap::hal::imaging {

// DepthRegistration of any two cameras: each pixel's ray is turned into the colour camera's frame once, and every
// reading is a point on it.
class ByRays {
 public:
  ByRays(const footprints::Rig& rig, const Intrinsics& depth, const std::array<double, 9>& rotation);
  DepthRegistration::Counts apply(std::span<const std::uint16_t> depth, std::uint16_t* registered);

 private:
  const footprints::Rig rig_;
  const std::size_t width_;
  std::vector<bool> blind_;  // of each row: colour sees nothing of it
  std::vector<float> x_, y_, z_;
  footprints::Covered covered_;
  const bool simd_, together_;
};

}  // namespace onemap::hal::imaging
