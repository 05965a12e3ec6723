#include "render/scene.hpp"

namespace onemap::render {

Color robot_color(std::size_t n) {
  static constexpr std::array<Color, 10> kColors{{{220, 40, 40},     // red
                                                  {40, 90, 220},     // blue
                                                  {30, 160, 60},     // green
                                                  {240, 190, 20},    // yellow
                                                  {210, 50, 200},    // magenta
                                                  {20, 175, 190},    // cyan
                                                  {245, 130, 30},    // orange
                                                  {125, 75, 200},    // violet
                                                  {130, 95, 60},     // brown
                                                  {90, 100, 110}}};  // slate
  return kColors[n % kColors.size()];
}

}  // namespace onemap::render
