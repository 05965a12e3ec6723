#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/raw_image.hpp"

namespace onemap::hal::imaging {

// A depth image in a sensor's raw form to native 16-bit values, 0 = no reading; depth holds width * height values.
// Total, as raw_colour.hpp.

// 16 bits a pixel, little endian (V4L2's Z16 and Y16), in the device's own unit, which is the calibration's
// depth_scale.
Status z16_to_depth(const RawImage& image, std::span<std::uint16_t> depth);

// Makes the device's value for "no reading" (65535 with some) 0.
void clear_value(std::uint16_t none, std::span<std::uint16_t> depth);

// Kinect v1: disparities of 11 bits, packed without gaps, the high bits first; 2047 = no reading. Rows have no padding,
// and the number of pixels is a multiple of 8.
Status unpack_disparity11(const RawImage& image, std::span<std::uint16_t> disparity);

// Kinect v1's disparities (in eighths of a pixel) to millimetres.
class KinectDisparity {
 public:
  // z = 8 focal_px baseline_m / (offset - disparity); OpenKinect's numbers unless the device gives its own.
  explicit KinectDisparity(double offset = 1090, double baseline_m = 0.075, double focal_px = 580);
  // Values above 2047, disparities at or behind the offset and depths over 10 m are no reading. In place is fine.
  void to_mm(std::span<const std::uint16_t> disparity, std::span<std::uint16_t> depth_mm) const;
  // The same of packed ones, as unpack_disparity11 takes them.
  Status packed_to_mm(const RawImage& image, std::span<std::uint16_t> depth_mm) const;

 private:
  std::array<std::uint16_t, 2048> mm_;
};

}  // namespace onemap::hal::imaging
