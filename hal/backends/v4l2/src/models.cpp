#include "models.hpp"

#include "shipped_calibrations.hpp"

namespace onemap::hal::v4l2 {

const Model* find_model(std::string_view usb_id) {
  for (const Model& model : kShipped)
    if (model.usb_id == usb_id) return &model;
  return nullptr;
}

}  // namespace onemap::hal::v4l2
