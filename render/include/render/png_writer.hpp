#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "hal/base/file.hpp"
#include "hal/base/result.hpp"
#include "render/image.hpp"

namespace onemap::render {

// The same image gives the same bytes (no time stamp, fixed compression).
Result<std::vector<std::uint8_t>> encode_png(const Image& image);
// Whole or not at all: see write_file().
Status write_png(const std::string& path, const Image& image, Durable durable = Durable::yes);

}  // namespace onemap::render
