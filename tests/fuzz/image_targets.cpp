#include <algorithm>
#include <array>
#include <cstring>

#include "fuzz/expect.hpp"
#include "fuzz/targets.hpp"
#include "hal/backends/openni2/decode.hpp"
#include "hal/imaging/image_file.hpp"
#include "hal/imaging/raw_colour.hpp"
#include "hal/imaging/raw_depth.hpp"
#include "hal/imaging/register_depth.hpp"
#include "hal/imaging/rig_calibration.hpp"
#include "hal/imaging/tabled_registration.hpp"

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

// As OpenNI2 hands them over: any of its formats, mirrored or not.
void openni2(bool colour, std::uint8_t how, const RawImage& image) {
  namespace ni = hal::openni2;
  const auto format = static_cast<ni::PixelFormat>(how % 7u);
  const bool mirrored = how >= 7;
  if (colour)
    decodes<std::uint8_t>(3 * image.size.pixels(),
                          [&](std::span<std::uint8_t> rgb) { return ni::decode_colour(format, image, mirrored, rgb); });
  else
    decodes<std::uint16_t>(image.size.pixels(),
                           [&](std::span<std::uint16_t> depth) { return ni::decode_depth(image, mirrored, depth); });
}

// A Kinect's packed disparities: to millimetres, and by tables that are anything, here the image's own bytes.
void kinect(bool tabled, std::uint8_t how, const RawImage& image) {
  using namespace hal::imaging;
  if (!tabled)
    return decodes<std::uint16_t>(
        image.size.pixels(), [&](std::span<std::uint16_t> mm) { return KinectDisparity().packed_to_mm(image, mm); });
  if (image.size.width < 8 || image.size.width % 8 != 0 || image.size.height < 1) return;
  std::vector<std::uint16_t> mm(2048);
  std::vector<std::int32_t> shift(10000), places(2 * image.size.pixels());
  for (std::size_t d = 0; d < mm.size(); ++d) mm[d] = static_cast<std::uint16_t>(d < 1024 ? 5 * d : d * how);
  for (std::size_t i = 0; i < std::min(image.bytes.size() / 4, shift.size()); ++i)
    std::memcpy(&shift[i], &image.bytes[4 * i], 4);
  for (std::size_t i = 0; i < std::min(image.bytes.size() / 4, places.size()); ++i)
    std::memcpy(&places[i], &image.bytes[4 * i], 4);
  TabledRegistration registration(image.size, {mm, shift, places, how});
  decodes<std::uint16_t>(image.size.pixels(),
                         [&](std::span<std::uint16_t> out) { return registration.apply(image.bytes, out); });
}

// A calibration file that is anything: what it is read as, registration can count with.
void rig(Bytes text) {
  using namespace hal::imaging;
  const auto rig = parse_rig_calibration({reinterpret_cast<const char*>(text.data()), text.size()}, "file");
  ONEMAP_FUZZ_EXPECT(rig.ok() || !rig.error().reason.empty());
  if (!rig || !rig->depth) return;
  const auto again = parse_rig_calibration(text_of(*rig), "again");
  ONEMAP_FUZZ_EXPECT(again.ok());
  const std::size_t depths = size_of(*rig->depth).pixels(), colours = size_of(rig->colour).pixels();
  if (depths > kMostPixels / 16 || colours > kMostPixels / 16) return;
  DepthRegistration registration(*rig->depth, rig->colour, rig->pose, rig->depth_offset_m);
  std::vector<std::uint16_t> depth(depths), registered(colours);
  for (std::size_t i = 0; i < depths; ++i) depth[i] = static_cast<std::uint16_t>(i * 2654435761u >> 16);
  const auto counts = registration.apply(depth, registered);
  ONEMAP_FUZZ_EXPECT(counts.outside <= counts.readings && counts.readings <= depths);
}

enum class File : std::uint8_t { colour, depth, plain_colour };

void file(Bytes input, File kind) {
  using hal::imaging::Chroma;
  const auto size = hal::imaging::image_size(input);
  ONEMAP_FUZZ_EXPECT(size.ok() || !size.error().reason.empty());
  if (!size || size->pixels() > kMostPixels) return;
  if (kind == File::depth)
    return decodes<std::uint16_t>(size->pixels(), [&](std::span<std::uint16_t> depth) {
      return hal::imaging::decode_depth(input, *size, depth);
    });
  const Chroma chroma = kind == File::colour ? Chroma::smooth : Chroma::plain;
  decodes<std::uint8_t>(3 * size->pixels(), [&](std::span<std::uint8_t> rgb) {
    return hal::imaging::decode_color(input, *size, rgb, chroma);
  });
}

}  // namespace

// The first byte's lower half is the decoder, its upper half what else it is told.
void image(Bytes input) {
  if (input.size() < 4) return;
  const std::size_t which = input[0] % 16u;
  const Bytes rest = input.subspan(4);
  if (which == 13) return rig(rest);
  if (which >= 6 && which <= 8)
    return file(rest, which == 6 ? File::colour : which == 7 ? File::depth : File::plain_colour);
  // As long as the image says or shorter, in memory of its own: the address sanitizer sees a byte too far.
  const std::vector<std::uint8_t> bytes(rest.begin(), rest.end());
  const RawImage image{bytes, ImageSize{input[1], input[2]}, input[3]};
  if (which < 6) raw(which, image);
  if (which == 9 || which == 10) openni2(which == 9, input[0] >> 4, image);
  if (which == 11 || which == 12) kinect(which == 12, input[0] >> 4, image);
}

}  // namespace onemap::fuzz
