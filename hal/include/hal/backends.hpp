#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/base/result.hpp"
#include "hal/depth_camera.hpp"

namespace onemap::hal {

// A camera address is BACKEND:REST, and REST is the backend's own: `replay:DIR`, `replay:DIR:FROM:TO`,
// `simulated:living-room?robot=2&seed=7`.
struct CameraAddress {
  std::string backend;
  std::string path;                            // before '?'
  std::map<std::string, std::string> options;  // after '?', key=value joined by '&'
  std::string text;                            // as given, for messages
};
Result<CameraAddress> parse_camera_address(std::string_view text);

// One row of the backend table. The table itself is explicit and lives with whoever links the backends (the daemon).
struct Backend {
  std::string_view name;
  std::string_view description;  // for --help: what it opens, with its address form
  Result<std::unique_ptr<DepthCamera>> (*open)(const CameraAddress& address);
  Status (*check)(const CameraAddress& address) = nullptr;  // the address's form alone: nothing is touched
};

// Whether open_camera() understands the address: its form, its backend, and what that knows of it without looking. The
// camera may still not be there.
Status check_address(std::span<const Backend> table, std::string_view address);

// Finds the address's backend in the table and opens the camera; an unknown backend's error lists the known ones.
Result<std::unique_ptr<DepthCamera>> open_camera(std::span<const Backend> table, std::string_view address);

}  // namespace onemap::hal
