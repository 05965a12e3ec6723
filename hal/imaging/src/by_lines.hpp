#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "footprints.hpp"
#include "hal/imaging/register_depth.hpp"
#include "sideways.hpp"

namespace onemap::hal::imaging {

// DepthRegistration of two pinholes beside each other that look the same way, as those of nominal calibrations: a row
// of depths comes to whole rows of colour's, and what a reading covers does not depend on its distance, but for where
// it begins. So no rays are kept, and a row is put together once, as a line, however many rows it covers.
class ByLines {
 public:
  static bool suits(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose);
  ByLines(const footprints::Rig& rig, const Intrinsics& depth);
  DepthRegistration::Counts apply(std::span<const std::uint16_t> depth, std::uint16_t* registered);

 private:
  struct Rows {
    std::size_t first, end;
  };
  sideways::Rig rig_;
  const std::size_t width_, most_;  // of depth's rows; columns of a reading
  std::vector<Rows> rows_;          // of colour's, of each row of depth's
  sideways::Covered covered_;
  std::vector<std::uint16_t> line_;
  const bool simd_;
};

}  // namespace onemap::hal::imaging
