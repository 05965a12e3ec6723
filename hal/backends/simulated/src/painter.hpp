#pragma once
#include "arithmetic.hpp"
#include "texture.hpp"

namespace onemap::hal::simulated {

enum class Style {
  wallpaper,
  plaster,
  ceiling,
  planks,
  tiles,
  concrete,
  carpet,
  wood,
  fabric,
  picture,
  poster,
  book,
  cardboard,
  metal,
  leaves,
  screen,
  door,
  outdoors,
  white_wall,
  oak,
  light_tiles,
  linen,
  cream,
  bare_wall,  // of one brightness: nothing to see but its edges
  bare_floor,
  bare_board,
};

// Paints one surface. The key decides every mark and colour: equal keys give equal surfaces, unlike ones nothing in
// common. light: how bright the surface stands, about 1.
Texture paint(Style style, std::uint64_t key, double width_m, double height_m, double light);

}  // namespace onemap::hal::simulated
