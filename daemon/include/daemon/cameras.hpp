#pragma once
#include <span>

#include "hal/backends.hpp"

namespace onemap::daemon {

// The cameras that this build knows: the explicit table, one row a backend. A new backend is a new row.
std::span<const hal::Backend> camera_backends();

}  // namespace onemap::daemon
