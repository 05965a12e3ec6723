#pragma once
#include <string_view>

namespace onemap::hal::v4l2 {

// A camera model that onemap ships a nominal calibration for: a file of calibration/, built in.
struct Model {
  std::string_view usb_id;  // "8086:0b07"
  std::string_view name;    // the file's
  std::string_view calibration;
};

// nullptr: not known.
const Model* find_model(std::string_view usb_id);

}  // namespace onemap::hal::v4l2
