#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/imaging/raw_image.hpp"

namespace onemap::hal::v4l2 {

// V4L2's pixel formats by their four characters, and what onemap makes of them. Pure.
using FourCc = std::uint32_t;

constexpr FourCc four_cc(const char (&text)[5]) {
  FourCc code = 0;
  for (unsigned i = 0; i < 4; ++i) code |= static_cast<FourCc>(static_cast<unsigned char>(text[i])) << (8 * i);
  return code;
}
std::string text_of(FourCc format);  // "Z16", "YUYV"; what is not printable as dots

constexpr FourCc kZ16 = four_cc("Z16 "), kY16 = four_cc("Y16 "), kYuyv = four_cc("YUYV"), kUyvy = four_cc("UYVY"),
                 kMjpeg = four_cc("MJPG"), kJpeg = four_cc("JPEG"), kGrey = four_cc("GREY");

// The best of what a node offers, 0 when there is none. Z16 is depth by its name; Y16 is depth or an infrared image, so
// it is taken only for a node that the user named (any_16_bits).
FourCc depth_format(std::span<const FourCc> offered, bool any_16_bits);
FourCc colour_format(std::span<const FourCc> offered);

// How good a colour format is, 0 the best: a sensor's own colours, then compressed ones, then none.
int colour_rank(FourCc format);

// A colour image in one of the formats above to RGB; the error carries a reason only.
Status decode_colour(FourCc format, const imaging::RawImage& image, std::span<std::uint8_t> rgb);

}  // namespace onemap::hal::v4l2
