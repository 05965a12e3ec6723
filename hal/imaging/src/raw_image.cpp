#include "hal/imaging/raw_image.hpp"

#include <fmt/format.h>

namespace onemap::hal::imaging {

namespace {
constexpr std::size_t kMaxStride = std::size_t{64} * kMostSide_px;
}  // namespace

Status check_rows(const RawImage& image, std::size_t row_bytes) {
  const auto [width, height] = image.size;
  if (width < 1 || height < 1 || width > kMostSide_px || height > kMostSide_px)
    return Error{"", fmt::format("an image of {}x{} pixels", width, height)};
  const std::size_t stride = image.stride(row_bytes);
  if (stride < row_bytes || stride > kMaxStride)
    return Error{"", fmt::format("rows of {} bytes where {} are needed", stride, row_bytes)};
  const std::size_t needed = (static_cast<std::size_t>(height) - 1) * stride + row_bytes;
  if (image.bytes.size() < needed)
    return Error{"",
                 fmt::format("the image has {} bytes, a {}x{} one has {}", image.bytes.size(), width, height, needed)};
  return success();
}

}  // namespace onemap::hal::imaging
