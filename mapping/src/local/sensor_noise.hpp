#pragma once

namespace onemap::mapping {

// Standard deviation of a structured-light sensor's depth, metres (Nguyen, Izadi and Lovell, 2012: Kinect v1).
inline float depth_sigma(float z_m) { return 0.0012f + 0.0019f * (z_m - 0.4f) * (z_m - 0.4f); }
inline double depth_sigma(double z_m) { return 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4); }

}  // namespace onemap::mapping
