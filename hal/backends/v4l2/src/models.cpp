#include "models.hpp"

#include "shipped_calibrations.hpp"

namespace onemap::hal::v4l2 {

std::vector<const Model*> find_models(std::string_view usb_id) {
  std::vector<const Model*> found;
  for (const Model& model : kShipped)
    if (model.usb_id == usb_id) found.push_back(&model);
  return found;
}

}  // namespace onemap::hal::v4l2
