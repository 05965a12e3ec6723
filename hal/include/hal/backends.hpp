#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "hal/depth_camera.hpp"

namespace onemap::hal {

// A camera address is BACKEND:REST, and REST is the backend's own: `replay:DIR`, `replay:DIR:FROM:TO`,
// `simulated:living-room?robot=2&seed=7`.
struct CameraAddress {
  std::string backend;
  std::string path;                            // before '?'
  std::map<std::string, std::string> options;  // after '?', key=value joined by '&'
  std::string text;                            // as given, for messages
  // Not part of the text: what a live backend adds to the kernel's monotonic stamps to get FrameTime. From whoever has
  // a clock; without one a stamp is counted from the machine's start.
  Duration clock_offset{};
};
Result<CameraAddress> parse_camera_address(std::string_view text);

// A camera that a backend found on this machine.
struct CameraInfo {
  std::string address;      // opens it
  std::string description;  // for people: model, serial number, bus
  std::string abilities;    // for people: formats, sizes, frame rates
  std::string problem;      // why it cannot be used; empty when it can
  std::string limits{};     // why it does less here than it could (DepthCamera::limits); empty when it does not
  bool operator==(const CameraInfo&) const = default;
};

// One row of the backend table. The table itself is explicit and lives with whoever links the backends (the daemon).
struct Backend {
  std::string_view name;
  std::string_view description;  // for --help: what it opens, with its address form
  Result<std::unique_ptr<DepthCamera>> (*open)(const CameraAddress& address);
  Status (*check)(const CameraAddress& address) = nullptr;  // form, options and the files that these name; no device
  // What is there now, the best first, without disturbing a camera in use. Null for what is not found but named
  // (recordings, simulations).
  std::vector<CameraInfo> (*list)() = nullptr;
};

// Whether open_camera() understands the address: its form, its backend, and what that knows of it without looking. The
// camera may still not be there.
Status check_address(std::span<const Backend> table, std::string_view address);

// Finds the address's backend in the table and opens the camera; an unknown backend's error lists the known ones.
// `auto` is best_of() the cameras that the table's backends list; its error names every camera and why it cannot be
// used.
Result<std::unique_ptr<DepthCamera>> open_camera(std::span<const Backend> table, std::string_view address,
                                                 Duration clock_offset = {});

// Every camera that the table's backends find on this machine, in the table's order.
std::vector<CameraInfo> list_cameras(std::span<const Backend> table);

// The first that can be used and does all that it can, else the first that can be used; null: none can.
const CameraInfo* best_of(std::span<const CameraInfo> cameras);

}  // namespace onemap::hal
