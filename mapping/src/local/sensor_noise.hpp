#pragma once
#include "hal/depth_noise.hpp"

namespace onemap::mapping {

// Standard deviation of depth, metres: a structured-light sensor's, whatever the camera.
inline float depth_sigma(float z_m) { return hal::DepthNoise{}.sigma_m(z_m); }
inline double depth_sigma(double z_m) { return hal::DepthNoise{}.sigma_m(z_m); }

}  // namespace onemap::mapping
