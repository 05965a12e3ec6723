#include "hal/imaging/raw_depth.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "disparity11.hpp"

namespace onemap::hal::imaging {

namespace {
constexpr std::size_t kNoDisparity = 2047;
constexpr double kFarthest_mm = 10000;

Status check_packed(const RawImage& image) {
  const bool is_size = image.size.width >= 1 && image.size.height >= 1;
  return disparity11::check(image.bytes, is_size ? image.size.pixels() : 0);
}
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

Status disparity11::check(std::span<const std::uint8_t> packed, std::size_t pixels) {
  if (pixels == 0 || pixels % kPixels != 0)
    return Error{"", std::to_string(pixels) + " pixels where a multiple of 8 is expected"};
  const std::size_t needed = pixels / kPixels * kBytes;
  if (packed.size() >= needed) return success();
  return Error{"", std::to_string(packed.size()) + " bytes where " + std::to_string(needed) + " are expected"};
}

Status unpack_disparity11(const RawImage& image, std::span<std::uint16_t> disparity) {
  assert(disparity.size() == image.size.pixels());
  if (Status status = check_packed(image); !status) return status;
  disparity11::unpack(image.bytes.data(), disparity, [](std::uint16_t value) { return value; });
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

Status KinectDisparity::packed_to_mm(const RawImage& image, std::span<std::uint16_t> depth_mm) const {
  assert(depth_mm.size() == image.size.pixels());
  if (Status status = check_packed(image); !status) return status;
  disparity11::unpack(image.bytes.data(), depth_mm, [this](std::uint16_t value) { return mm_[value]; });
  return success();
}

}  // namespace onemap::hal::imaging
