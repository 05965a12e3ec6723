#pragma once
#include <span>
#include <string>

#include "hal/backends.hpp"

namespace onemap::daemon {

// The cameras that this build knows: the explicit table, one row a backend. A new backend is a new row.
std::span<const hal::Backend> camera_backends();

// What onemapctl reads (control/found_cameras.hpp), in one line.
std::string cameras_json_text(std::span<const hal::CameraInfo> cameras);

// The same for people.
std::string cameras_text(std::span<const hal::CameraInfo> cameras);

}  // namespace onemap::daemon
