#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/raw_image.hpp"

namespace onemap::hal::imaging {

// What a factory measured of a Kinect v1, as libfreenect works it out of the device's own numbers. Views.
struct FactoryTables {
  std::span<const std::uint16_t> mm_of_disparity;  // 2048; 0 and 10000 and more: none
  std::span<const std::int32_t> shift_of_mm;       // to the right, in 1/256 of a column
  std::span<const std::int32_t> places;            // of each pixel: the column in 1/256, and the row
  std::int32_t less = 0;                           // pixels that all are nearer to the image's start than that
};

// Kinect v1's packed disparities onto the colour image's pixels by such tables, in millimetres: what libfreenect's
// registered depth is, to the millimetre. One reading gives one pixel, and where several fall on one the nearest is
// kept. Takes all memory when it is made.
class TabledRegistration {
 public:
  // The width is a multiple of 8. Whatever the tables say, nothing outside the image is touched.
  TabledRegistration(ImageSize size, const FactoryTables& tables);
  ~TabledRegistration();

  // registered holds width * height values, all of which are written; 0 = no reading. The error is that of
  // unpack_disparity11().
  Status apply(std::span<const std::uint8_t> packed, std::span<std::uint16_t> registered);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace onemap::hal::imaging
