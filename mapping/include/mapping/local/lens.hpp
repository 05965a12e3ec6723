#pragma once
#include "hal/frame.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// The lens: OpenCV's model with five coefficients (k1 k2 p1 p2 k3), about the pinhole fx fy cx cy.

// The pixel that images the ray (x, y, 1).
Eigen::Vector2d distorted_pixel(const hal::Intrinsics& k, const Eigen::Vector2d& ray);

// The ray (x, y, 1) that a pixel images, by the fixed point of ray = (distorted - tangential) / radial. Where the model
// cannot be inverted it is any ray, or none that is finite: see inverts().
Eigen::Vector2d undistorted_ray(const hal::Intrinsics& k, double u_px, double v_px);

// Whether the pixel's ray falls on that pixel again, within a pixel, and is no farther from the axis than 85 degrees.
bool inverts(const hal::Intrinsics& k, double u_px, double v_px);

}  // namespace onemap::mapping
