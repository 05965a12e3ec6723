#pragma once
#include "hal/base/range.hpp"

namespace onemap::hal {

// The standard deviation of a depth camera's reading: smallest at one distance and growing with the square of the
// distance from there. The defaults are those of Kinect v1 (Nguyen, Izadi and Lovell, 2012).
struct DepthNoise {
  double least_m = 0.0012;       // at best_m
  double growth_per_m = 0.0019;  // metres of deviation per square metre
  double best_m = 0.4;

  // Metres, for a depth of z_m metres; in the argument's own precision.
  template <class Real>
  constexpr Real sigma_m(Real z_m) const {
    const Real off = z_m - static_cast<Real>(best_m);
    return static_cast<Real>(least_m) + static_cast<Real>(growth_per_m) * off * off;
  }
  bool operator==(const DepthNoise&) const = default;
};

// What a depth camera can have.
inline constexpr Range<double> kLeastNoise_m{1e-5, 0.1}, kNoiseGrowth_per_m{0, 0.1}, kBestDistance_m{0, 10};

}  // namespace onemap::hal
