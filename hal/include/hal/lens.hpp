#pragma once
#include "hal/base/range.hpp"
#include "hal/frame.hpp"

namespace onemap::hal {

// A point of the plane at distance 1 (a ray is (x, y, 1)), or of the image in pixels.
struct Point2 {
  double x = 0, y = 0;
  bool operator==(const Point2&) const = default;
};

// The lens: OpenCV's model with five coefficients (k1 k2 p1 p2 k3), about the pinhole fx fy cx cy.

// The pixel that images a ray.
Point2 pixel_of(const Intrinsics& k, Point2 ray);

// The ray that a pixel images, by the fixed point of ray = (distorted - tangential) / radial. Where the model cannot be
// inverted it is any ray, or none that is finite: see has_ray().
Point2 ray_of(const Intrinsics& k, Point2 pixel);

// Whether the pixel's ray falls on that pixel again, within a pixel, and is no farther from the axis than 85 degrees.
bool has_ray(const Intrinsics& k, Point2 pixel);

bool has_distortion(const Intrinsics& k);

// What a pinhole camera with depth can have.
inline constexpr Range<double> kFocalLengthWidths{0.1, 20};  // in image widths: fields of view from 3 to 157 degrees
inline constexpr Range<double> kDepthScale{100, 1e5};        // depth values a metre

}  // namespace onemap::hal
