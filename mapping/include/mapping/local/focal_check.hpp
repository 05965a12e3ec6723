#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "hal/depth_noise.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// The focal length that the camera claims, as a share of the one that fits what it saw.
struct FocalEstimate {
  double ratio = 1;  // 1.1: the claimed one is too long by a tenth
  double sigma = 1;  // of the ratio's logarithm
  int views = 0;     // pairs of views that it rests on

  // Whether the claimed one is wrong by more than a lens that is merely uncalibrated would be: a tenth, and no chance.
  bool wrong() const;
};

// Notices a wrong focal length. Distances between points stay the same from view to view; a camera that turned sees
// some of what lay beside its axis as depth, and only with the right focal length do the two agree: for two points
// whose lateral distance is D and whose depths are Z apart (squared, as the claimed lens has them), c^2 D + Z is the
// same in both views, where c is the claimed focal length as a share of the true one. So c^2 = (Z2 - Z1) / (D1 - D2):
// no pose is needed, and the scale of depth does not matter. Of each pair of views the median counts, and of all pairs
// of views their median. Memory is taken in the constructor; deterministic.
class FocalCheck {
 public:
  explicit FocalCheck(std::size_t max_points, const hal::DepthNoise& noise = {});
  // The same points in two views, in either camera's frame by the claimed lens; z > 0. Wrong matches may be among them.
  void add(std::span<const Vector3d> a, std::span<const Vector3d> b);
  FocalEstimate estimate() const;

 private:
  static constexpr std::size_t kViews = 64;  // the latest
  std::size_t max_points_;
  hal::DepthNoise noise_;
  std::vector<double> found_;  // logarithms of c, of one pair of views
  std::array<double, kViews> views_{};
  std::size_t added_ = 0;
};

}  // namespace onemap::mapping
