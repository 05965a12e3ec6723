#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::render {

// Writes a file whole or not at all: into a temporary file beside it, then renamed over it. The error names the path
// and the system's reason (no such directory, no space left on device, ...); the temporary file is removed.
Status write_file(const std::string& path, std::span<const std::uint8_t> bytes);

Result<std::vector<std::uint8_t>> read_file(const std::string& path);

}  // namespace onemap::render
