#include "mapping/image.hpp"

namespace onemap::mapping {

void to_gray(std::span<const std::uint8_t> rgb, std::span<std::uint8_t> out) {
  const std::uint8_t* in = rgb.data();
  std::uint8_t* to = out.data();
  for (std::size_t i = 0, n = out.size(); i < n; ++i, in += 3)
    to[i] = static_cast<std::uint8_t>((77 * in[0] + 150 * in[1] + 29 * in[2] + 128) >> 8);
}

}  // namespace onemap::mapping
