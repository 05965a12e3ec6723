#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::hal::replay {

// The whole file into `into`, whose memory is reused. Refuses what is not a regular file, and files over 256 MiB.
Status read_file(const std::filesystem::path& path, std::vector<std::uint8_t>& into);

}  // namespace onemap::hal::replay
