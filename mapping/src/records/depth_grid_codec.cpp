#include "records/depth_grid_codec.hpp"

#include <zstd.h>

#include <algorithm>
#include <bit>

namespace onemap::mapping {

namespace {

constexpr int kZstdLevel = 19;

std::size_t cells(const DepthGrid& grid) { return static_cast<std::size_t>(grid.width) * grid.height; }
std::size_t mask_bytes(std::size_t cells) { return (cells + 7) / 8; }
std::size_t most_content(std::size_t cells) { return mask_bytes(cells) + 2 * cells; }
bool bit(std::span<const std::uint8_t> mask, std::size_t i) { return ((mask[i / 8] >> (i % 8)) & 1) != 0; }

std::uint16_t zigzag(int v) { return static_cast<std::uint16_t>(v < 0 ? -2 * v - 1 : 2 * v); }
int unzigzag(std::uint16_t v) { return (v & 1) != 0 ? -((v + 1) / 2) : v / 2; }

// What the cells above and to the left let expect of cell i, the next in order; without any it is the last depth.
int expected(const std::vector<std::uint16_t>& depth, std::size_t i, std::size_t width, int last) {
  const std::size_t u = i % width;
  const int left = u > 0 ? depth[i - 1] : 0, above = i >= width ? depth[i - width] : 0;
  const int corner = u > 0 && i >= width ? depth[i - width - 1] : 0;
  if (left == 0 || above == 0) return left != 0 ? left : above != 0 ? above : corner != 0 ? corner : last;
  if (corner == 0) return (left + above) / 2;
  const auto [low, high] = std::minmax(left, above);
  return std::clamp(left + above - corner, low, high);
}

std::vector<std::uint8_t> to_content(const DepthGrid& grid) {
  std::vector<std::uint8_t> mask(mask_bytes(cells(grid))), low, high;
  int last = 0;
  for (std::size_t i = 0; i < cells(grid); ++i) {
    if (grid.inverse_depth[i] == 0) continue;
    mask[i / 8] = static_cast<std::uint8_t>(mask[i / 8] | (1u << (i % 8)));
    const std::uint16_t off = zigzag(grid.inverse_depth[i] - expected(grid.inverse_depth, i, grid.width, last));
    low.push_back(static_cast<std::uint8_t>(off & 0xFF));
    high.push_back(static_cast<std::uint8_t>(off >> 8));
    last = grid.inverse_depth[i];
  }
  mask.insert(mask.end(), low.begin(), low.end());
  mask.insert(mask.end(), high.begin(), high.end());
  return mask;
}

// The frame's content, or nothing and an error. It is taken only when it is of a size that so many cells can have.
std::vector<std::uint8_t> decompress(FieldReader& in, std::size_t cells) {
  const auto frame = in.bytes(in.remaining(), "grid.depth");
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  in.require(size != ZSTD_CONTENTSIZE_ERROR && size != ZSTD_CONTENTSIZE_UNKNOWN, "grid.depth",
             "not a sized zstd frame");
  in.require(size >= mask_bytes(cells) && size <= most_content(cells), "grid.depth",
             "content of another size than the cells can have");
  in.require(frame.size() <= ZSTD_compressBound(most_content(cells)), "grid.depth", "longer than the cells can need");
  in.require(ZSTD_findFrameCompressedSize(frame.data(), frame.size()) == frame.size(), "grid.depth",
             "not one zstd frame");
  if (!in.ok()) return {};
  std::vector<std::uint8_t> content(static_cast<std::size_t>(size));
  const std::size_t got = ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size());
  in.require(ZSTD_isError(got) == 0 && got == content.size(), "grid.depth", "damaged zstd frame");
  return content;
}

// The planes' sizes fit each other, and the mask ends with the grid.
bool is_whole(FieldReader& in, std::span<const std::uint8_t> content, std::size_t cells) {
  if (!in.ok()) return false;
  const auto mask = content.first(mask_bytes(cells));
  std::size_t depths = 0;
  for (const std::uint8_t byte : mask) depths += static_cast<std::size_t>(std::popcount(byte));
  in.require(cells % 8 == 0 || mask.back() >> (cells % 8) == 0, "grid.depth", "bits beyond the last cell");
  in.require(content.size() == mask.size() + 2 * depths, "grid.depth", "not as many depths as the mask says");
  return in.ok();
}

}  // namespace

void put(ByteWriter& out, const DepthGrid& grid) {
  out.put(grid.width);
  out.put(grid.height);
  for (const std::int32_t k : grid.fx_fy_cx_cy) out.put(k);
  if (cells(grid) == 0) return;
  const std::vector<std::uint8_t> content = to_content(grid);
  std::vector<std::uint8_t> frame(ZSTD_compressBound(content.size()));
  // The bound was kept, so compression cannot have failed.
  frame.resize(ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), kZstdLevel));
  out.bytes(frame);
}

DepthGrid read_grid_head(FieldReader& in) {
  DepthGrid out;
  out.width = in.get<std::uint16_t>("grid.width");
  out.height = in.get<std::uint16_t>("grid.height");
  in.require(out.width <= DepthGrid::kMostWidth && out.height <= DepthGrid::kMostHeight, "grid.width",
             "larger than 160 x 120");
  in.require((out.width == 0) == (out.height == 0), "grid.height", "zero on one side only");
  for (auto& k : out.fx_fy_cx_cy) k = in.get<std::int32_t>("grid.fx_fy_cx_cy");
  in.require(out.fx_fy_cx_cy[0] > 0 && out.fx_fy_cx_cy[1] > 0, "grid.fx_fy_cx_cy", "focal length not positive");
  return in.ok() ? out : DepthGrid{};
}

void read_grid_depths(FieldReader& in, DepthGrid& grid) {
  const std::size_t count = cells(grid);
  if (!in.ok() || count == 0) return;
  const std::vector<std::uint8_t> content = decompress(in, count);
  if (!is_whole(in, content, count)) return;
  const auto mask = std::span(content).first(mask_bytes(count)), rest = std::span(content).subspan(mask.size());
  const auto low = rest.first(rest.size() / 2), high = rest.subspan(low.size());
  grid.inverse_depth.resize(count);
  int last = 0;
  for (std::size_t i = 0, n = 0; i < count; ++i) {
    if (!bit(mask, i)) continue;
    const auto off = static_cast<std::uint16_t>(low[n] | (high[n] << 8));
    ++n;
    last = expected(grid.inverse_depth, i, grid.width, last) + unzigzag(off);
    in.require(last >= DepthGrid::kFarthest && last <= DepthGrid::kNearest, "grid.depth", "out of range");
    if (!in.ok()) return;
    grid.inverse_depth[i] = static_cast<std::uint16_t>(last);
  }
}

}  // namespace onemap::mapping
