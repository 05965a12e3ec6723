#pragma once
#include <string_view>
#include <vector>

namespace onemap::hal::v4l2 {

// A camera model that onemap ships a nominal calibration for: a file of calibration/, built in. A model has several
// where its images of different shapes are not one another's scaled pictures.
struct Model {
  std::string_view usb_id;  // "8086:0b07"
  std::string_view name;    // the file's
  std::string_view calibration;
};

// Empty: not known.
std::vector<const Model*> find_models(std::string_view usb_id);

}  // namespace onemap::hal::v4l2
