#pragma once
#include <span>
#include <string>

#include "hal/backends.hpp"

namespace onemap::daemon {

// The cameras that this build knows: the explicit table, one row a backend. A new backend is a new row.
std::span<const hal::Backend> camera_backends();

// For people: what is there, what it can do, why one cannot be used, and what `auto` opens.
std::string cameras_text(std::span<const hal::CameraInfo> cameras);

}  // namespace onemap::daemon
