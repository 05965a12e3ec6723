#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace onemap::render {

// An RGB picture, 8 bits a channel, rows from the top, no padding.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // 3 * width * height

  Image() = default;
  Image(int width_px, int height_px, std::array<std::uint8_t, 3> fill = {0, 0, 0});
  std::array<std::uint8_t, 3> at(int x, int y) const;  // inside the picture
  void set(int x, int y, std::array<std::uint8_t, 3> color);

 private:
  std::size_t offset(int x, int y) const;
};

}  // namespace onemap::render
