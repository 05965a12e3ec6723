#include "render/scene.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace onemap::render {
namespace {

constexpr std::array<Color, 10> kColors{{{220, 40, 40},     // red
                                         {40, 90, 220},     // blue
                                         {30, 160, 60},     // green
                                         {240, 190, 20},    // yellow
                                         {210, 50, 200},    // magenta
                                         {20, 175, 190},    // cyan
                                         {245, 130, 30},    // orange
                                         {125, 75, 200},    // violet
                                         {130, 95, 60},     // brown
                                         {90, 100, 110}}};  // slate

// Robots count from one; a name without a number stands where its letters (FNV-1a) say.
std::size_t number_of(const std::string& name) {
  std::size_t digits = 0;
  while (digits < name.size() && digits < 6 &&
         std::isdigit(static_cast<unsigned char>(name[name.size() - 1 - digits])) != 0)
    ++digits;
  if (digits > 0) return static_cast<std::size_t>(std::stoul(name.substr(name.size() - digits))) + kColors.size() - 1;
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

}  // namespace

Color robot_color(std::size_t n) { return kColors[n % kColors.size()]; }

std::vector<Color> robot_colors(const std::vector<std::string>& names) {
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return names[a] < names[b]; });
  std::array<bool, kColors.size()> taken{};
  std::vector<Color> colors(names.size());
  for (const std::size_t i : order) {
    const std::size_t wanted = number_of(names[i]) % kColors.size();
    std::size_t n = wanted;
    for (std::size_t k = 0; k < kColors.size() && taken[n]; ++k) n = (n + 1) % kColors.size();
    if (taken[n]) n = wanted;
    taken[n] = true;
    colors[i] = robot_color(n);
  }
  return colors;
}

}  // namespace onemap::render
