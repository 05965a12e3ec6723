#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/backends/openni2/decode.hpp"
#include "hal/base/result.hpp"

namespace onemap::hal::openni2 {

struct Mode {
  PixelFormat format = PixelFormat::other;
  int width = 0, height = 0, fps = 0;  // pixels, frames a second
  bool operator==(const Mode&) const = default;
};
std::string to_string(const Mode& mode);

struct ModePair {
  Mode depth, colour;
  bool operator==(const ModePair&) const = default;
};

// Chooses modes of the same size and rate, of formats that decode: the wanted one, or without a wish 640x480@30 and
// else the first that depth has in common with colour. Depth in millimetres goes before 100 micrometres, which end at
// 6.5 m; RGB goes before what must be converted. The error lists what there is.
Result<ModePair> choose_modes(std::span<const Mode> depth, std::span<const Mode> colour,
                              const std::optional<Mode>& wanted);

// WIDTHxHEIGHT@FPS; nothing when the text is anything else.
std::optional<Mode> parse_mode(std::string_view text);

}  // namespace onemap::hal::openni2
