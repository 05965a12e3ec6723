#pragma once
#include "hal/frame.hpp"

namespace onemap::hal::imaging {

// A point of the image plane at distance 1 (a ray is (x, y, 1)), or of the image in pixels.
struct Point {
  double x = 0, y = 0;
};

// OpenCV's lens model with five coefficients (k1 k2 p1 p2 k3) about the pinhole: the pixel that images a ray, and the
// ray of a pixel (by the fixed point of ray = (distorted - tangential) / radial; not finite where there is none).
Point pixel_of(const Intrinsics& k, Point ray);
Point ray_of(const Intrinsics& k, Point pixel);

bool has_distortion(const Intrinsics& k);

}  // namespace onemap::hal::imaging
