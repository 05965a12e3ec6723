// The submap body: a header, then one zstd frame with planes that compress well:
//   keys (12 bytes a block), masks of observed voxels (64 bytes a block), masks of coloured ones among the observed,
//   then for the observed voxels in order: the distance's and the weight's steps beside what is expected, and for the
//   coloured ones those of green, red - green, blue - green (voxel_coding.hpp), a byte each.
// zstd's output may differ between its versions, so what is canonical is the content of the frame: one frame, its
// declared size exact, nothing behind it.
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

#include "mapping/records/submap.hpp"
#include "records/field_reader.hpp"
#include "records/voxel_coding.hpp"
#include "records/voxel_planes.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxBlocks = 512;
constexpr std::size_t kMaskBytes = kBlockVoxels / 8;
constexpr std::size_t kKeyBytes = 12;
constexpr std::size_t kMostVoxelBytes = 6;  // of the planes, colour mask included
constexpr std::size_t kLeastBlockBytes = kKeyBytes + kMaskBytes;
constexpr std::size_t kMostBlockBytes = kLeastBlockBytes + kBlockVoxels * kMostVoxelBytes;
constexpr std::int32_t kFarthestBlock = 1 << 20;
constexpr int kZstdLevel = 15;
constexpr std::size_t kMostPlaneEnd = 16;  // what ending a block early may cost

void set_bit(std::vector<std::uint8_t>& mask, std::size_t i) {
  mask[i / 8] = static_cast<std::uint8_t>(mask[i / 8] | (1u << (i % 8)));
}

std::size_t ones(std::span<const std::uint8_t> mask) {
  std::size_t n = 0;
  for (; mask.size() >= 8; mask = mask.subspan(8)) {
    std::uint64_t eight;
    std::memcpy(&eight, mask.data(), 8);
    n += static_cast<std::size_t>(std::popcount(eight));
  }
  for (const std::uint8_t byte : mask) n += static_cast<std::size_t>(std::popcount(byte));
  return n;
}

struct Planes {
  std::vector<std::uint8_t> keys, seen, colored;
  std::array<std::vector<std::uint8_t>, kVoxelChannels> channels;
};

Planes to_planes(const SubmapRecord& record) {
  Planes out;
  out.seen.resize(record.blocks.size() * kMaskBytes);
  ByteWriter keys(out.keys);
  VoxelPredictor predictor;
  std::size_t index = 0, observed = 0;
  for (const SubmapBlock& block : record.blocks) {
    for (const std::int32_t c : {block.key.x, block.key.y, block.key.z}) keys.put(c);
    predictor.begin_block();
    for (const SubmapVoxel& voxel : block.voxels) {
      const VoxelSteps steps = to_steps(voxel);
      const std::size_t at = index++;
      if (steps.seen) {
        set_bit(out.seen, at);
        if (observed % 8 == 0) out.colored.push_back(0);
        if (steps.colored) set_bit(out.colored, observed);
        ++observed;
      }
      const int channels = steps.colored ? kVoxelChannels : steps.seen ? kGreen : 0;
      for (int c = 0; c < channels; ++c) {
        const auto channel = static_cast<VoxelChannel>(c);
        out.channels[channel].push_back(static_cast<std::uint8_t>(steps.value[channel] - predictor.expected(channel)));
      }
      predictor.set(steps);
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

// The voxels' planes as spans of the decompressed content; each has the size that the masks before it say.
VoxelPlanes read_planes(FieldReader& in, std::size_t blocks) {
  constexpr std::array<const char*, kVoxelChannels> kNames{"blocks.tsdf", "blocks.weight", "blocks.rgb", "blocks.rgb",
                                                           "blocks.rgb"};
  VoxelPlanes out;
  out.seen = in.bytes(blocks * kMaskBytes, "blocks.seen");
  const std::size_t observed = ones(out.seen);
  out.colored = in.bytes((observed + 7) / 8, "blocks.colored");
  const std::size_t colors = ones(out.colored);
  if (observed % 8 != 0 && !out.colored.empty())
    in.require(out.colored.back() >> (observed % 8) == 0, "blocks.colored", "bits beyond the last voxel");
  for (const VoxelChannel channel : {kTsdf, kWeight, kGreen, kRed, kBlue})
    out.channels[channel] = in.bytes(channel >= kGreen ? colors : observed, kNames[channel]);
  return out;
}

void read_voxels(FieldReader& in, std::vector<SubmapBlock>& blocks) {
  const VoxelPlanes planes = read_planes(in, blocks.size());
  if (in.ok()) in.require(decode_voxels(planes, blocks), "blocks.voxels", "steps that no voxel has");
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

// One frame behind `body`, and in it each plane by itself: what one is like says nothing about the next.
void compress(const Planes& planes, std::vector<std::uint8_t>& body) {
  std::vector<const std::vector<std::uint8_t>*> all{&planes.keys, &planes.seen, &planes.colored};
  for (const auto& plane : planes.channels) all.push_back(&plane);
  std::size_t size = 0;
  for (const auto* plane : all) size += plane->size();
  const std::size_t header = body.size();
  body.resize(header + ZSTD_compressBound(size) + all.size() * kMostPlaneEnd);
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kZstdLevel);
  // What repeats in noise is no match worth its place, so matches are hardly looked for: smaller than with the level's
  // tables (0.2 % on recordings and on simulated rooms), in a third of the time, and without tables of megabytes a
  // record.
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_strategy, ZSTD_btultra2);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_minMatch, 7);
  for (const ZSTD_cParameter table : {ZSTD_c_hashLog, ZSTD_c_chainLog})
    ZSTD_CCtx_setParameter(context.get(), table, 6);  // the least there is
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_searchLog, 1);
  ZSTD_CCtx_setPledgedSrcSize(context.get(), size);
  ZSTD_outBuffer out{&body[header], body.size() - header, 0};
  for (std::size_t i = 0; i < all.size(); ++i) {
    ZSTD_inBuffer in{all[i]->data(), all[i]->size(), 0};
    // There is room for everything, so once is enough, and it cannot fail.
    ZSTD_compressStream2(context.get(), &out, &in, i + 1 == all.size() ? ZSTD_e_end : ZSTD_e_flush);
  }
  body.resize(header + out.pos);
  body.shrink_to_fit();  // the body is kept for the team's whole life, and the bound is many times its size
}

}  // namespace

std::vector<std::uint8_t> encode(const SubmapRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  out.put(record.anchor_keyframe);
  out.put(record.voxel_um);
  out.put(record.truncation_um);
  out.put(static_cast<std::uint16_t>(record.blocks.size()));
  compress(to_planes(record), body);
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
