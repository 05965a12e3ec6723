#include "formats.hpp"

#include <algorithm>
#include <array>

#include "hal/imaging/image_file.hpp"
#include "hal/imaging/raw_colour.hpp"

namespace onemap::hal::v4l2 {

namespace {

constexpr std::array kColours{kYuyv, kUyvy, kMjpeg, kJpeg, kGrey};  // the best first

bool offers(std::span<const FourCc> offered, FourCc format) {
  return std::ranges::find(offered, format) != offered.end();
}

}  // namespace

std::string text_of(FourCc format) {
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const char c = static_cast<char>(format >> (8 * i) & 0xFF);
    text += c >= ' ' && c <= '~' ? c : '.';
  }
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

FourCc depth_format(std::span<const FourCc> offered, bool any_16_bits) {
  if (offers(offered, kZ16)) return kZ16;
  return any_16_bits && offers(offered, kY16) ? kY16 : 0;
}

FourCc colour_format(std::span<const FourCc> offered) {
  for (const FourCc format : kColours)
    if (offers(offered, format)) return format;
  return 0;
}

int colour_rank(FourCc format) { return static_cast<int>(std::ranges::find(kColours, format) - kColours.begin()); }

Status decode_colour(FourCc format, const imaging::RawImage& image, std::span<std::uint8_t> rgb) {
  switch (format) {
    case kYuyv:
      return imaging::yuyv_to_rgb(image, rgb);
    case kUyvy:
      return imaging::uyvy_to_rgb(image, rgb);
    case kGrey:
      return imaging::grey_to_rgb(image, rgb);
    case kMjpeg:
    case kJpeg:
      return imaging::decode_color(image.bytes, image.size, rgb, imaging::Chroma::plain);
    default:
      return Error{"", "no decoder for " + text_of(format)};
  }
}

}  // namespace onemap::hal::v4l2
