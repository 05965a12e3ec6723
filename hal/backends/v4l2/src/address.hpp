#pragma once
#include <optional>
#include <string>

#include "hal/backends.hpp"
#include "hal/imaging/image_size.hpp"

namespace onemap::hal::v4l2 {

// What a `v4l2:` address asks for; see hal/backends/v4l2.hpp.
struct V4l2Address {
  std::string text, depth_path, colour_path, calibration_file;
  std::optional<imaging::ImageSize> size, depth_size;
  int fps = 30;
  bool as_it_comes = false;  // depth is not registered
  Duration clock_offset{};
};
Result<V4l2Address> parse_v4l2_address(const CameraAddress& address);

}  // namespace onemap::hal::v4l2
