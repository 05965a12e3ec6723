#pragma once
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::control {

// Becomes the program onemap-calibrate with these words: it reads images, and onemapctl knows no camera. The program is
// beside this one or in PATH. Returns only why that failed.
Error become_calibrate(const std::vector<std::string>& words);

}  // namespace onemap::control
