#include "hal/backends/openni2/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

namespace onemap::hal::openni2 {

namespace {

constexpr Mode kUsual{PixelFormat::other, 640, 480, 30};
constexpr std::array kByPreference{PixelFormat::depth_1_mm, PixelFormat::depth_100_um, PixelFormat::rgb888,
                                   PixelFormat::yuv422,     PixelFormat::yuyv,         PixelFormat::grey8};

bool same_size_and_rate(const Mode& a, const Mode& b) {
  return a.width == b.width && a.height == b.height && a.fps == b.fps;
}

// The best format among the modes of the size and rate.
std::optional<Mode> best(std::span<const Mode> modes, const Mode& like, bool (*usable)(PixelFormat)) {
  for (const PixelFormat format : kByPreference)
    for (const Mode& mode : modes)
      if (mode.format == format && usable(format) && same_size_and_rate(mode, like)) return mode;
  return std::nullopt;
}

std::string_view name(PixelFormat format) {
  switch (format) {
    case PixelFormat::depth_1_mm:
      return "1 mm";
    case PixelFormat::depth_100_um:
      return "100 um";
    case PixelFormat::rgb888:
      return "RGB";
    case PixelFormat::yuv422:
      return "YUV422";
    case PixelFormat::yuyv:
      return "YUYV";
    case PixelFormat::grey8:
      return "grey";
    case PixelFormat::other:
      return "in a format that is not decoded";
  }
  return "unknown";
}

std::string list(std::span<const Mode> modes) {
  std::string text;
  for (const Mode& mode : modes) text += (text.empty() ? "" : ", ") + to_string(mode);
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::string to_string(const Mode& mode) {
  return fmt::format("{}x{}@{} {}", mode.width, mode.height, mode.fps, name(mode.format));
}

Result<ModePair> choose_modes(std::span<const Mode> depth, std::span<const Mode> colour,
                              const std::optional<Mode>& wanted) {
  std::vector<Mode> wishes{wanted.value_or(kUsual)};
  if (!wanted) wishes.insert(wishes.end(), depth.begin(), depth.end());
  for (const Mode& wish : wishes) {
    const auto d = best(depth, wish, is_depth), c = best(colour, wish, is_colour);
    if (d && c) return ModePair{*d, *c};
  }
  const std::string what = wanted ? fmt::format("mode {}x{}@{}", wanted->width, wanted->height, wanted->fps)
                                  : std::string("size and rate that depth and colour have in common");
  return Error{"", fmt::format("there is no {}; depth has {}; colour has {}", what, list(depth), list(colour))};
}

std::optional<Mode> parse_mode(std::string_view text) {
  Mode mode;
  const char *at = text.data(), *const end = at + text.size();
  const auto number = [&](int& into, char before) {
    if (before != '\0' && (at == end || *at++ != before)) return false;
    const auto [next, code] = std::from_chars(at, end, into);
    at = next;
    return code == std::errc{} && into > 0;
  };
  const bool good = number(mode.width, '\0') && number(mode.height, 'x') && number(mode.fps, '@') && at == end;
  return good ? std::optional(mode) : std::nullopt;
}

}  // namespace onemap::hal::openni2
