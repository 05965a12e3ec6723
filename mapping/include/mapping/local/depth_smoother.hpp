#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace onemap::mapping {

// Structured light measures inverse depth, in which planes are linear, with the same noise everywhere: in metres it
// grows with the square of the depth, and from two metres on it is a third of a voxel and more. There a reading in the
// middle of five by five that lie on one plane, as far as noise lets tell, becomes what that plane says there. Beside
// edges, holes and bends nothing changes. Equal bytes on every machine.
class DepthSmoother {
 public:
  // Images of more rows allocate once.
  explicit DepthSmoother(std::size_t rows);
  // A depth image (m, 0 = none), in place, of which the outermost pixels on each side are empty. simd false: the plain
  // twin.
  void smooth(float* depth_m, int width, int height, bool simd = true);
  std::size_t bytes() const;
  static std::size_t bytes_for(std::size_t rows) { return 2 * rows * sizeof(Pair); }

 private:
  // The image is gone through in strips from left to right: what the last two columns of one were before they were
  // smoothed, which the next one asks, too.
  using Pair = std::array<float, 2>;
  std::vector<Pair> left_, right_;
};

}  // namespace onemap::mapping
