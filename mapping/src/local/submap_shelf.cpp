#include "submap_shelf.hpp"

#include <algorithm>
#include <span>

#include "hal/base/bytes.hpp"

namespace onemap::mapping {
namespace {

// A block: its key, the mask of its observed voxels, and of each of these 7 bytes.
constexpr std::size_t kMaskBytes = kBlockVoxels / 8;
constexpr std::size_t kBlockBytes = 12 + kMaskBytes, kVoxelBytes = 7;

std::size_t size_of(const VoxelMap& voxels) {
  std::size_t bytes = 0;
  voxels.for_each([&](const BlockView& block) {
    bytes += kBlockBytes;
    for (const Voxel& voxel : block.voxels) bytes += voxel.weight > 0 ? kVoxelBytes : 0;
  });
  return bytes;
}

std::uint8_t* put(const Voxel& voxel, std::uint8_t* at) {
  at = put_little_endian(at, static_cast<std::int16_t>(voxel.tsdf()));
  *at++ = static_cast<std::uint8_t>(std::min<int>(voxel.weight, 255));
  *at++ = static_cast<std::uint8_t>(voxel.color_weight);
  for (const std::uint8_t channel : voxel.color()) *at++ = channel;
  return at;
}

std::uint8_t* put(const BlockView& block, std::uint8_t* at) {
  for (const std::int32_t axis : {block.key.x, block.key.y, block.key.z}) at = put_little_endian(at, axis);
  std::uint8_t* mask = at;
  at = std::fill_n(at, kMaskBytes, std::uint8_t{0});
  for (std::size_t i = 0; i < block.voxels.size(); ++i) {
    if (block.voxels[i].weight == 0) continue;
    mask[i / 8] = static_cast<std::uint8_t>(mask[i / 8] | (1u << (i % 8)));
    at = put(block.voxels[i], at);
  }
  return at;
}

Voxel get_voxel(ByteReader& in) {
  Voxel out;
  const int tsdf = in.get<std::int16_t>();
  out.weight = in.get<std::uint8_t>();
  out.tsdf_sum = tsdf * out.weight;
  const std::uint8_t colors = in.get<std::uint8_t>();
  out.color_weight = colors;
  for (std::uint16_t& sum : out.rgb_sum) sum = static_cast<std::uint16_t>(in.get<std::uint8_t>() * colors);
  return out;
}

}  // namespace

SubmapShelf::SubmapShelf(std::size_t budget_bytes) : ring_(budget_bytes), entries_(kMostEntries) {
  make_resident(ring_);
}

std::optional<std::size_t> SubmapShelf::find(std::uint32_t anchor) const {
  for (std::size_t i = 0; i < count_; ++i)
    if (entry(i).anchor.keyframe == anchor && !entry(i).taken) return (first_ + i) % kMostEntries;
  return std::nullopt;
}

// Where so many bytes lie together and unused.
std::optional<std::size_t> SubmapShelf::place_for(std::size_t bytes) const {
  if (count_ == kMostEntries) return std::nullopt;
  if (count_ == 0) return bytes <= ring_.size() ? std::optional<std::size_t>(0) : std::nullopt;
  const std::size_t begin = entry(0).begin;
  const bool wrapped = end_ <= begin;
  if (end_ + bytes <= (wrapped ? begin : ring_.size())) return end_;
  return !wrapped && bytes <= begin ? std::optional<std::size_t>(0) : std::nullopt;
}

void SubmapShelf::drop_oldest() {
  dropped_ += entry(0).taken ? 0 : 1;
  first_ = (first_ + 1) % kMostEntries;
  --count_;
}

std::size_t SubmapShelf::blocks(std::uint32_t anchor) const {
  const auto at = find(anchor);
  return at ? entries_[*at].blocks : 0;
}

bool SubmapShelf::put(const SubmapAnchor& anchor, const VoxelMap& voxels) {
  const std::size_t bytes = size_of(voxels);
  if (bytes > ring_.size()) return ++dropped_, false;
  std::optional<std::size_t> begin;
  while (!(begin = place_for(bytes))) drop_oldest();
  std::uint8_t* at = ring_.data() + *begin;
  voxels.for_each([&](const BlockView& block) { at = mapping::put(block, at); });
  entries_[(first_ + count_++) % kMostEntries] = {anchor, voxels.used(), *begin, bytes, false};
  end_ = *begin + bytes;
  return true;
}

void SubmapShelf::restore(const Entry& entry, VoxelMap& into) const {
  ByteReader in(std::span<const std::uint8_t>(ring_).subspan(entry.begin, entry.bytes));
  while (in.remaining() > 0) {
    BlockKey key;
    for (std::int32_t* axis : {&key.x, &key.y, &key.z}) *axis = in.get<std::int32_t>();
    const auto mask = in.bytes(kMaskBytes);
    Voxel* voxels = into.find_or_add(key);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      if (((mask[i / 8] >> (i % 8)) & 1) == 0) continue;
      const Voxel voxel = get_voxel(in);
      if (voxels != nullptr) voxels[i] = voxel;
    }
  }
  into.mark_handed_out();
}

bool SubmapShelf::take(std::uint32_t anchor, VoxelMap& into) {
  const auto at = find(anchor);
  if (!at) return false;
  restore(entries_[*at], into);
  entries_[*at].taken = true;
  return true;
}

void SubmapShelf::place(const SubmapAnchor& anchor) {
  if (const auto at = find(anchor.keyframe)) entries_[*at].anchor = anchor;
}

void SubmapShelf::for_each(VoxelMap& scratch,
                           const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entry(i).taken) continue;
    scratch.clear();
    restore(entry(i), scratch);
    fn(entry(i).anchor, scratch);
  }
  scratch.clear();
}

}  // namespace onemap::mapping
