#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"

namespace onemap::hal::imaging {

// A number and its standard deviation, which is infinite where nothing tells the number.
struct Estimate {
  double value = 0, sigma = 0;
};

// How many metres are to be added to all depths of a camera, so that what is flat in the room is flat in its images:
// the inverse depth of a plane is linear in the ray, 1 / (z + offset) = a x + b y + c, and a wrong offset bends planes
// that reach from near to far (a floor, a wall that one looks along). Planes say nothing of depth's scale: a room that
// is larger has the same planes. Pure; deterministic.
class PlaneOffset {
 public:
  PlaneOffset(const Intrinsics& depth, const DepthNoise& noise);
  void add(std::span<const std::uint16_t> depth);  // one image; images from different places say more
  std::size_t planes() const { return planes_.size(); }
  // Its deviation is that of the images among each other, and 2 mm for what is not flat; it needs four images.
  Estimate estimate() const;

 private:
  struct Sample {
    float x, y, z_m;  // the ray, and the depth
  };
  struct Plane {
    int image = 0;
    std::vector<Sample> samples;
  };
  struct Word {
    double lacking_m = 0, information = 0;
  };
  struct Cell;
  std::vector<Cell> cells_of(std::span<const std::uint16_t> depth) const;
  Word word_of(const Plane& plane, double offset) const;
  double without(int group, int groups) const;

  Intrinsics k_;
  DepthNoise noise_;
  int columns_, rows_, images_ = 0;
  std::vector<Plane> planes_;
};

}  // namespace onemap::hal::imaging
