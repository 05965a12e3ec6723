#include <algorithm>
#include <array>

#include "fuzz/expect.hpp"
#include "fuzz/targets.hpp"
#include "hal/imaging/image_file.hpp"
#include "hal/imaging/raw_colour.hpp"
#include "hal/imaging/raw_depth.hpp"

namespace onemap::fuzz {

namespace {

using hal::imaging::ImageSize;
using hal::imaging::RawImage;

constexpr std::size_t kMostPixels = std::size_t{1} << 20;

// Pixels, or an error with a reason; and the same again.
template <class Pixel, class Decode>
void decodes(std::size_t values, Decode decode) {
  std::vector<Pixel> first(values, 1), second(values, 2);
  const Status status = decode(first);
  ONEMAP_FUZZ_EXPECT(status.ok() || !status.error().reason.empty());
  ONEMAP_FUZZ_EXPECT(decode(second).ok() == status.ok());
  ONEMAP_FUZZ_EXPECT(!status.ok() || first == second);
}

void raw(std::size_t which, const RawImage& image) {
  using Colour = Status (*)(const RawImage&, std::span<std::uint8_t>);
  using Depth = Status (*)(const RawImage&, std::span<std::uint16_t>);
  constexpr std::array<Colour, 4> kColours{hal::imaging::yuyv_to_rgb, hal::imaging::uyvy_to_rgb,
                                           hal::imaging::grey_to_rgb, hal::imaging::bayer_grbg_to_rgb};
  constexpr std::array<Depth, 2> kDepths{hal::imaging::z16_to_depth, hal::imaging::unpack_disparity11};
  const std::size_t pixels = image.size.pixels();
  if (which < kColours.size()) {
    decodes<std::uint8_t>(3 * pixels, [&](std::span<std::uint8_t> rgb) { return kColours[which](image, rgb); });
  } else {
    const Depth decode = kDepths[which - kColours.size()];
    decodes<std::uint16_t>(pixels, [&](std::span<std::uint16_t> depth) { return decode(image, depth); });
  }
}

void file(Bytes input, bool colour) {
  const auto size = hal::imaging::image_size(input);
  ONEMAP_FUZZ_EXPECT(size.ok() || !size.error().reason.empty());
  if (!size || size->pixels() > kMostPixels) return;
  if (colour)
    decodes<std::uint8_t>(3 * size->pixels(),
                          [&](std::span<std::uint8_t> rgb) { return hal::imaging::decode_color(input, *size, rgb); });
  else
    decodes<std::uint16_t>(size->pixels(), [&](std::span<std::uint16_t> depth) {
      return hal::imaging::decode_depth(input, *size, depth);
    });
}

}  // namespace

void image(Bytes input) {
  if (input.size() < 4) return;
  const std::size_t which = input[0] % 8u;
  const Bytes rest = input.subspan(4);
  if (which >= 6) return file(rest, which == 6);
  // As long as the image says or shorter, in memory of its own: the address sanitizer sees a byte too far.
  const std::vector<std::uint8_t> bytes(rest.begin(), rest.end());
  raw(which, {bytes, ImageSize{input[1], input[2]}, input[3]});
}

}  // namespace onemap::fuzz
