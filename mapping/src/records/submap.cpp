// The submap body: a header, then one zstd frame with planes that compress well:
//   keys (12 bytes a block), masks of observed voxels (64 bytes a block), masks of coloured ones among the observed,
//   then for the observed voxels in order: low bytes and high bytes of the distance's change, the weight's change, and
//   for the coloured ones the changes of green, red - green, blue - green.
// zstd's output may differ between its versions, so what is canonical is the content of the frame: one frame, its
// declared size exact, nothing behind it.
#include <zstd.h>

#include <algorithm>
#include <bit>

#include "mapping/records/submap.hpp"
#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxBlocks = 512;
constexpr std::size_t kMaskBytes = kBlockVoxels / 8;
constexpr std::size_t kKeyBytes = 12;
constexpr std::size_t kMostVoxelBytes = 7;  // of the planes, colour mask included
constexpr std::size_t kLeastBlockBytes = kKeyBytes + kMaskBytes;
constexpr std::size_t kMostBlockBytes = kLeastBlockBytes + kBlockVoxels * kMostVoxelBytes;
constexpr std::int32_t kFarthestBlock = 1 << 20;
constexpr int kZstdLevel = 3;

std::uint16_t zigzag(int v) { return static_cast<std::uint16_t>(v < 0 ? -2 * v - 1 : 2 * v); }
int unzigzag(std::uint16_t v) { return (v & 1) != 0 ? -((v + 1) / 2) : v / 2; }
bool has_color(const SubmapVoxel& voxel) { return voxel.rgb != Rgb{}; }

void set_bit(std::vector<std::uint8_t>& mask, std::size_t i) {
  mask[i / 8] = static_cast<std::uint8_t>(mask[i / 8] | (1u << (i % 8)));
}
bool bit(std::span<const std::uint8_t> mask, std::size_t i) { return ((mask[i / 8] >> (i % 8)) & 1) != 0; }

std::size_t ones(std::span<const std::uint8_t> mask) {
  std::size_t n = 0;
  for (const std::uint8_t byte : mask) n += static_cast<std::size_t>(std::popcount(byte));
  return n;
}

// Writes bytes as differences to the one before (modulo 256), and reads them back.
struct DeltaBytes {
  std::uint8_t last = 0;
  std::uint8_t put(int value) {
    const auto now = static_cast<std::uint8_t>(value);
    const auto out = static_cast<std::uint8_t>(now - last);
    last = now;
    return out;
  }
  std::uint8_t get(std::uint8_t change) { return last = static_cast<std::uint8_t>(last + change); }
};

struct Planes {
  std::vector<std::uint8_t> keys, seen, colored, tsdf_low, tsdf_high, weight, green, red, blue;
};

Planes to_planes(const SubmapRecord& record) {
  Planes out;
  out.seen.resize(record.blocks.size() * kMaskBytes);
  ByteWriter keys(out.keys);
  DeltaBytes weight, green, red, blue;
  int tsdf = 0;
  std::size_t index = 0, observed = 0;
  for (const SubmapBlock& block : record.blocks) {
    for (const std::int32_t c : {block.key.x, block.key.y, block.key.z}) keys.put(c);
    for (const SubmapVoxel& voxel : block.voxels) {
      const std::size_t at = index++;
      if (voxel.weight == 0) continue;
      set_bit(out.seen, at);
      const std::uint16_t change = zigzag(voxel.tsdf - tsdf);
      tsdf = voxel.tsdf;
      out.tsdf_low.push_back(static_cast<std::uint8_t>(change & 0xFF));
      out.tsdf_high.push_back(static_cast<std::uint8_t>(change >> 8));
      out.weight.push_back(weight.put(voxel.weight));
      if (observed % 8 == 0) out.colored.push_back(0);
      const std::size_t n = observed++;
      if (!has_color(voxel)) continue;
      set_bit(out.colored, n);
      out.green.push_back(green.put(voxel.rgb[1]));
      out.red.push_back(red.put(voxel.rgb[0] - voxel.rgb[1]));
      out.blue.push_back(blue.put(voxel.rgb[2] - voxel.rgb[1]));
    }
  }
  return out;
}

void read_keys(FieldReader& in, std::vector<SubmapBlock>& blocks) {
  for (std::size_t i = 0; i < blocks.size() && in.ok(); ++i) {
    BlockKey& key = blocks[i].key;
    for (std::int32_t* c : {&key.x, &key.y, &key.z}) {
      *c = in.get<std::int32_t>("blocks.key");
      in.require(*c > -kFarthestBlock && *c < kFarthestBlock, "blocks.key", "too far");
    }
    in.require(i == 0 || blocks[i - 1].key < key, "blocks.key", "not sorted");
  }
}

// The voxels' planes as spans of the decompressed content.
struct PlaneReader {
  std::span<const std::uint8_t> seen, colored, tsdf_low, tsdf_high, weight, green, red, blue;

  PlaneReader(FieldReader& in, std::size_t blocks) {
    seen = in.bytes(blocks * kMaskBytes, "blocks.seen");
    const std::size_t observed = ones(seen);
    colored = in.bytes((observed + 7) / 8, "blocks.colored");
    const std::size_t colors = ones(colored);
    if (observed % 8 != 0 && !colored.empty())
      in.require(colored.back() >> (observed % 8) == 0, "blocks.colored", "bits beyond the last voxel");
    tsdf_low = in.bytes(observed, "blocks.tsdf");
    tsdf_high = in.bytes(observed, "blocks.tsdf");
    weight = in.bytes(observed, "blocks.weight");
    green = in.bytes(colors, "blocks.rgb");
    red = in.bytes(colors, "blocks.rgb");
    blue = in.bytes(colors, "blocks.rgb");
  }
};

void read_voxels(FieldReader& in, std::vector<SubmapBlock>& blocks) {
  const PlaneReader planes(in, blocks.size());
  if (!in.ok()) return;
  DeltaBytes weight, green, red, blue;
  int tsdf = 0;
  std::size_t observed = 0, color = 0;
  for (std::size_t i = 0; i < blocks.size() * kBlockVoxels; ++i) {
    if (!bit(planes.seen, i)) continue;
    SubmapVoxel& voxel = blocks[i / kBlockVoxels].voxels[i % kBlockVoxels];
    const std::size_t n = observed++;
    tsdf += unzigzag(static_cast<std::uint16_t>(planes.tsdf_low[n] | (planes.tsdf_high[n] << 8)));
    in.require(tsdf >= -kTsdfOne && tsdf <= kTsdfOne, "blocks.tsdf", "beyond the truncation distance");
    voxel.weight = weight.get(planes.weight[n]);
    in.require(voxel.weight != 0, "blocks.weight", "zero in an observed voxel");
    if (!in.ok()) return;
    voxel.tsdf = static_cast<std::int16_t>(tsdf);
    if (!bit(planes.colored, n)) continue;
    voxel.rgb[1] = green.get(planes.green[color]);
    voxel.rgb[0] = static_cast<std::uint8_t>(red.get(planes.red[color]) + voxel.rgb[1]);
    voxel.rgb[2] = static_cast<std::uint8_t>(blue.get(planes.blue[color]) + voxel.rgb[1]);
    in.require(has_color(voxel), "blocks.rgb", "no colour in a coloured voxel");
    ++color;
  }
}

// The declared size of the frame's content, within what so many blocks can need.
std::size_t content_size(FieldReader& in, std::span<const std::uint8_t> frame, std::size_t blocks) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  in.require(size != ZSTD_CONTENTSIZE_ERROR && size != ZSTD_CONTENTSIZE_UNKNOWN, "blocks", "not a sized zstd frame");
  in.require(size >= blocks * kLeastBlockBytes, "blocks", "more than the content holds");
  in.require(size <= blocks * kMostBlockBytes, "blocks", "more content than the blocks can need");
  in.require(ZSTD_findFrameCompressedSize(frame.data(), frame.size()) == frame.size(), "blocks", "not one zstd frame");
  return in.ok() ? static_cast<std::size_t>(size) : 0;
}

SubmapHeader read_header(FieldReader& in, std::span<const std::uint8_t>& frame) {
  SubmapHeader out;
  out.anchor_keyframe = in.get<std::uint32_t>("anchor_keyframe");
  out.voxel_um = in.get<std::int32_t>("voxel_um");
  in.require(out.voxel_um >= 1000 && out.voxel_um <= 1'000'000, "voxel_um", "not 1 mm to 1 m");
  out.truncation_um = in.get<std::int32_t>("truncation_um");
  in.require(out.truncation_um >= out.voxel_um && out.truncation_um <= std::int64_t{100} * out.voxel_um,
             "truncation_um", "not 1 to 100 voxels");
  out.blocks = in.get<std::uint16_t>("blocks");
  in.require(out.blocks <= kMaxBlocks, "blocks", "more than 512");
  frame = in.bytes(in.remaining(), "blocks");
  if (in.ok()) out.content_bytes = content_size(in, frame, out.blocks);
  return out;
}

std::vector<std::uint8_t> decompress(FieldReader& in, std::span<const std::uint8_t> frame, std::size_t size) {
  std::vector<std::uint8_t> content(size);
  const std::size_t got = ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size());
  in.require(ZSTD_isError(got) == 0 && got == content.size(), "blocks", "damaged zstd frame");
  return content;
}

}  // namespace

std::vector<std::uint8_t> encode(const SubmapRecord& record) {
  const Planes planes = to_planes(record);
  std::vector<std::uint8_t> content;
  for (const auto* plane : {&planes.keys, &planes.seen, &planes.colored, &planes.tsdf_low, &planes.tsdf_high,
                            &planes.weight, &planes.green, &planes.red, &planes.blue})
    content.insert(content.end(), plane->begin(), plane->end());
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  out.put(record.anchor_keyframe);
  out.put(record.voxel_um);
  out.put(record.truncation_um);
  out.put(static_cast<std::uint16_t>(record.blocks.size()));
  const std::size_t header = body.size();
  body.resize(header + ZSTD_compressBound(content.size()));
  const std::size_t size =
      ZSTD_compress(&body[header], body.size() - header, content.data(), content.size(), kZstdLevel);
  body.resize(header + size);  // the bound was kept, so compression cannot have failed
  body.shrink_to_fit();        // the body is kept for the team's whole life, and the bound is many times its size
  return body;
}

Result<SubmapHeader> decode_submap_header(std::span<const std::uint8_t> body) {
  FieldReader in("submap", body);
  std::span<const std::uint8_t> frame;
  const SubmapHeader header = read_header(in, frame);
  return in.finish(header);
}

Result<SubmapRecord> decode_submap(std::span<const std::uint8_t> body) {
  FieldReader in("submap", body);
  std::span<const std::uint8_t> frame;
  const SubmapHeader header = read_header(in, frame);
  if (!in.ok()) return in.finish(SubmapRecord{});
  const std::vector<std::uint8_t> content = decompress(in, frame, header.content_bytes);
  if (!in.ok()) return in.finish(SubmapRecord{});
  SubmapRecord out{header.anchor_keyframe, header.voxel_um, header.truncation_um, {}};
  FieldReader inner("submap", content);
  out.blocks.resize(header.blocks);
  read_keys(inner, out.blocks);
  read_voxels(inner, out.blocks);
  return inner.finish(std::move(out));
}

}  // namespace onemap::mapping
