#include "hal/imaging/raw_depth.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace onemap::hal::imaging {

namespace {
constexpr std::size_t kNoDisparity = 2047;
constexpr double kFarthest_mm = 10000;
}  // namespace

Status z16_to_depth(const RawImage& image, std::span<std::uint16_t> depth) {
  static_assert(std::endian::native == std::endian::little, "rows are copied as they are");
  assert(depth.size() == image.size.pixels());
  const std::size_t width = static_cast<std::size_t>(std::max(0, image.size.width)), row_bytes = 2 * width;
  if (Status status = check_rows(image, row_bytes); !status) return status;
  for (std::size_t v = 0; v < static_cast<std::size_t>(image.size.height); ++v)
    std::memcpy(depth.data() + v * width, image.bytes.data() + v * image.stride(row_bytes), row_bytes);
  return success();
}

void clear_value(std::uint16_t none, std::span<std::uint16_t> depth) {
  for (std::uint16_t& value : depth) value = value == none ? std::uint16_t{0} : value;
}

Status unpack_disparity11(const RawImage& image, std::span<std::uint16_t> disparity) {
  assert(disparity.size() == image.size.pixels());
  const std::size_t pixels = image.size.pixels();
  if (image.size.width < 1 || image.size.height < 1 || pixels % 8 != 0)
    return Error{"", std::to_string(pixels) + " pixels where a multiple of 8 is expected"};
  if (image.bytes.size() < pixels / 8 * 11)
    return Error{
        "", std::to_string(image.bytes.size()) + " bytes where " + std::to_string(pixels / 8 * 11) + " are expected"};
  const std::uint8_t* in = image.bytes.data();
  for (std::size_t i = 0; i < pixels; i += 8, in += 11) {
    std::uint32_t bits = 0;
    int have = 0, at = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      for (; have < 11; have += 8) bits = bits << 8 | in[at++];
      have -= 11;
      disparity[i + k] = static_cast<std::uint16_t>(bits >> have & 0x7FFu);
    }
  }
  return success();
}

KinectDisparity::KinectDisparity(double offset, double baseline_m, double focal_px) : mm_{} {
  const double scaled = 8 * 1000 * focal_px * baseline_m;
  for (std::size_t d = 0; d < kNoDisparity; ++d) {
    const double z_mm = scaled / (offset - static_cast<double>(d));
    if (z_mm > 0 && z_mm <= kFarthest_mm) mm_[d] = static_cast<std::uint16_t>(std::floor(z_mm + 0.5));
  }
}

void KinectDisparity::to_mm(std::span<const std::uint16_t> disparity, std::span<std::uint16_t> depth_mm) const {
  assert(disparity.size() == depth_mm.size());
  for (std::size_t i = 0; i < disparity.size(); ++i)
    depth_mm[i] = disparity[i] < mm_.size() ? mm_[disparity[i]] : std::uint16_t{0};
}

}  // namespace onemap::hal::imaging
