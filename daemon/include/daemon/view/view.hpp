#pragma once
#include "daemon/view/view_options.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

// Reads the map, draws and converts as told, and says on standard output what it wrote; on a terminal, progress of a
// sequence goes to standard error.
Status run_view(const ViewOptions& options);

}  // namespace onemap::daemon
