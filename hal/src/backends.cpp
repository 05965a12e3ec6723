#include "hal/backends.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace onemap::hal {

Result<CameraAddress> parse_camera_address(std::string_view text) {
  CameraAddress address;
  address.text = text;
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0)
    return Error{"camera address '" + address.text + "'", "expected BACKEND:PLACE, for example replay:DIR, or auto"};
  address.backend = text.substr(0, colon);
  std::string_view rest = text.substr(colon + 1);
  const std::size_t question = rest.find('?');
  address.path = rest.substr(0, question);
  std::string_view query = question == std::string_view::npos ? std::string_view{} : rest.substr(question + 1);
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    const std::size_t equals = pair.find('=');
    if (equals == std::string_view::npos || equals == 0)
      return Error{"camera address '" + address.text + "'", "option '" + std::string(pair) + "' is not key=value"};
    const bool is_new = address.options.emplace(pair.substr(0, equals), pair.substr(equals + 1)).second;
    if (!is_new)
      return Error{"camera address '" + address.text + "'", "option '" + std::string(pair) + "' is given twice"};
  }
  return address;
}

namespace {

Result<const Backend*> find_backend(std::span<const Backend> table, const CameraAddress& address) {
  std::string known;
  for (const Backend& backend : table) {
    if (backend.name == address.backend) return &backend;
    known += (known.empty() ? "" : ", ") + std::string(backend.name);
  }
  return Error{"camera address '" + address.text + "'", "no backend '" + address.backend + "'; known: " + known};
}

Result<std::string> address_of_best(std::span<const Backend> table) {
  const std::vector<CameraInfo> cameras = list_cameras(table);
  if (const CameraInfo* best = best_of(cameras)) return best->address;
  std::string refused;
  for (const CameraInfo& camera : cameras)
    refused += "; " + camera.address + " (" + camera.description + "): " + camera.problem;
  return Error{"camera address 'auto'", "no usable camera on this machine" + refused};
}

}  // namespace

Status check_address(std::span<const Backend> table, std::string_view address) {
  if (address == "auto") return success();
  const auto parsed = parse_camera_address(address);
  if (!parsed) return parsed.error();
  const auto backend = find_backend(table, *parsed);
  if (!backend) return backend.error();
  return (*backend)->check ? (*backend)->check(*parsed) : success();
}

std::vector<CameraInfo> list_cameras(std::span<const Backend> table) {
  std::vector<CameraInfo> all;
  for (const Backend& backend : table) {
    if (!backend.list) continue;
    std::vector<CameraInfo> found = backend.list();
    std::move(found.begin(), found.end(), std::back_inserter(all));
  }
  return all;
}

const CameraInfo* best_of(std::span<const CameraInfo> cameras) {
  const CameraInfo* usable = nullptr;
  for (const CameraInfo& camera : cameras) {
    if (!camera.problem.empty()) continue;
    if (camera.limits.empty()) return &camera;
    if (!usable) usable = &camera;
  }
  return usable;
}

Result<std::unique_ptr<DepthCamera>> open_camera(std::span<const Backend> table, std::string_view address,
                                                 Duration clock_offset) {
  if (address == "auto") {
    const auto found = address_of_best(table);
    if (!found) return found.error();
    return open_camera(table, *found, clock_offset);
  }
  auto parsed = parse_camera_address(address);
  if (!parsed) return parsed.error();
  parsed->clock_offset = clock_offset;
  const auto backend = find_backend(table, *parsed);
  if (!backend) return backend.error();
  return (*backend)->open(*parsed);
}

}  // namespace onemap::hal
