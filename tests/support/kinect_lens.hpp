#pragma once
#include "hal/frame.hpp"

namespace onemap::test {

// A Kinect as it was calibrated (640 x 480, strong distortion).
inline hal::Intrinsics kinect_lens() {
  return {.fx = 517.306408,
          .fy = 516.469215,
          .cx = 318.643040,
          .cy = 255.313989,
          .k1 = 0.262383,
          .k2 = -0.953104,
          .p1 = -0.005358,
          .p2 = 0.002628,
          .k3 = 1.163314};
}

}  // namespace onemap::test
