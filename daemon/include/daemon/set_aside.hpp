#pragma once
#include <string>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// A file that should be read and is not what it should be: it is kept for whoever wants to know why, as FILE.corrupt-1
// or the next number that is free, and is in nobody's way. The answer is its new name. After nine the ninth is
// replaced: what breaks every day must not fill the disk.
Result<std::string> set_aside(const std::string& file);

}  // namespace onemap::daemon
