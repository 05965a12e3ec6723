#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "mapping/team/atlas.hpp"

namespace onemap::test {

// What fuse_submap() does, as plainly as it can be said: every voxel of the global map near a source block is looked
// at, and every corner is looked up. The order of the sums of doubles is part of what is said: it decides the bytes.
class SlowResampler {
 public:
  SlowResampler(const std::vector<mapping::SubmapBlock>& blocks, std::int32_t voxel_um, std::int32_t truncation_um,
                const mapping::QuantizedPose& pose, mapping::VoxelMap& map)
      : source_um_(voxel_um), truncation_um_(truncation_um), pose_(pose), T_(from_quantized(pose)), map_(map) {
    for (const mapping::SubmapBlock& block : blocks) blocks_[block.key] = &block;
    find_grid();
  }

  // In order of key, as the blocks are; false: something saturated or had no room.
  bool fuse(mapping::Fusing how) {
    exact_ = true;
    for (const auto& [key, block] : blocks_) {
      asked_.clear();
      const auto [low, high] = reach(key);
      for (std::int64_t z = low[2]; z <= high[2]; ++z)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t x = low[0]; x <= high[0]; ++x) fuse_voxel(key, {x, y, z}, how);
    }
    return exact_;
  }

 private:
  using Index = std::array<std::int64_t, 3>;
  struct Sample {
    std::int64_t tsdf = 0, weight = 0, color = 0;
    std::array<std::int64_t, 3> rgb{};
  };
  static constexpr std::int64_t kOne = 1 << 24;

  static std::int64_t rounded(std::int64_t a, std::int64_t b) { return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b); }

  // A voxel more than the block on every side.
  std::array<Index, 2> reach(const mapping::BlockKey& key) const {
    Index low{}, high{};
    const mapping::Vector3d middle(8.0 * key.x + 4, 8.0 * key.y + 4, 8.0 * key.z + 4);
    const mapping::Vector3d at = T_ * mapping::Vector3d(middle * (static_cast<double>(source_um_) * 1e-6));
    const double radius = 5.5 * std::sqrt(3.0) * static_cast<double>(source_um_) / map_.config().voxel_um();
    for (int i = 0; i < 3; ++i) {
      const double centre = at[i] / (map_.config().voxel_um() * 1e-6);
      low[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::floor(centre - radius - 1));
      high[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::ceil(centre + radius + 1));
    }
    return {low, high};
  }

  // s = A (g + 0.5) + b
  void find_grid() {
    const double scale = static_cast<double>(map_.config().voxel_um()) / static_cast<double>(source_um_);
    for (std::size_t i = 0; i < 3; ++i) {
      double along = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const double r = T_.R(static_cast<int>(j), static_cast<int>(i));
        A_[i][j] = r * scale;
        along = along + r * pose_.t_10um[j];
      }
      b_[i] = -(along * 10 / static_cast<double>(source_um_)) - 0.5;
    }
  }

  // In 1/256 of a source voxel.
  Index position(const Index& g) const {
    Index out{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double s = A_[i][0] * (static_cast<double>(g[0]) + 0.5) + A_[i][1] * (static_cast<double>(g[1]) + 0.5) +
                       A_[i][2] * (static_cast<double>(g[2]) + 0.5) + b_[i];
      out[i] = static_cast<std::int64_t>(std::floor(s * 256 + 0.5));
    }
    return out;
  }

  const mapping::SubmapVoxel* source(const Index& at) const {
    const auto block = [](std::int64_t v) { return static_cast<std::int32_t>(v >> 3); };
    const auto found = blocks_.find({block(at[0]), block(at[1]), block(at[2])});
    if (found == blocks_.end()) return nullptr;
    const mapping::SubmapVoxel& voxel =
        found->second->voxels[static_cast<std::size_t>(((at[2] & 7) * 8 + (at[1] & 7)) * 8 + (at[0] & 7))];
    return voxel.weight == 0 ? nullptr : &voxel;
  }

  std::optional<Sample> mean(const Index& position) const {
    Sample out;
    int least = mapping::kTsdfOne, most = -mapping::kTsdfOne;
    for (std::size_t c = 0; c < 8; ++c) {
      Index corner{};
      std::int64_t share = 1;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::int64_t upper = (c >> i) & 1, fraction = position[i] & 255;
        corner[i] = (position[i] >> 8) + upper;
        share *= upper != 0 ? fraction : 256 - fraction;
      }
      if (share == 0) continue;
      const mapping::SubmapVoxel* voxel = source(corner);
      if (voxel == nullptr) return std::nullopt;
      least = std::min<int>(least, voxel->tsdf);
      most = std::max<int>(most, voxel->tsdf);
      out.tsdf += share * voxel->tsdf;
      out.weight += share * voxel->weight;
      if (voxel->rgb == mapping::Rgb{}) continue;
      out.color += share;
      for (std::size_t i = 0; i < 3; ++i) out.rgb[i] += share * voxel->rgb[i];
    }
    if (2 * (most - least) > 3 * mapping::kTsdfOne) return std::nullopt;
    return out;
  }

  void fuse_voxel(const mapping::BlockKey& key, const Index& g, mapping::Fusing how) {
    const Index at = position(g);
    if ((at[0] >> 11) != key.x || (at[1] >> 11) != key.y || (at[2] >> 11) != key.z) return;
    const auto sample = mean(at);
    if (!sample) return;
    const int tsdf =
        static_cast<int>(rounded(rounded(sample->tsdf * truncation_um_, map_.config().truncation_um()), kOne));
    if (tsdf < -mapping::kTsdfOne || tsdf > mapping::kTsdfOne) return;
    mapping::Voxel* voxel = target(g);
    if (voxel == nullptr) {
      exact_ = false;
      return;
    }
    put(*sample, tsdf, how, *voxel);
  }

  void put(const Sample& sample, int tsdf, mapping::Fusing how, mapping::Voxel& voxel) {
    const int weight = static_cast<int>(std::max<std::int64_t>(1, rounded(sample.weight, kOne)));
    std::array<int, 3> rgb{};
    for (std::size_t i = 0; i < 3 && sample.color != 0; ++i)
      rgb[i] = static_cast<int>(rounded(sample.rgb[i], sample.color));
    if (how == mapping::Fusing::take_back) {
      voxel.take_tsdf(tsdf, weight);
      if (sample.color != 0) voxel.take_color(rgb[0], rgb[1], rgb[2]);
      return;
    }
    if (voxel.would_saturate(weight) || (sample.color != 0 && voxel.color_would_saturate())) exact_ = false;
    voxel.add_tsdf(tsdf, weight);
    if (sample.color != 0) voxel.add_color(rgb[0], rgb[1], rgb[2]);
  }

  // Each block is asked for once for each source block, even when it is refused.
  mapping::Voxel* target(const Index& g) {
    const mapping::BlockKey key{static_cast<std::int32_t>(g[0] >> 3), static_cast<std::int32_t>(g[1] >> 3),
                                static_cast<std::int32_t>(g[2] >> 3)};
    const auto [slot, is_new] = asked_.try_emplace(key, nullptr);
    if (is_new) slot->second = map_.find_or_add(key);
    return slot->second == nullptr ? nullptr : slot->second + ((g[2] & 7) * 8 + (g[1] & 7)) * 8 + (g[0] & 7);
  }

  const std::int64_t source_um_, truncation_um_;
  const mapping::QuantizedPose pose_;
  const mapping::Pose T_;
  mapping::VoxelMap& map_;
  std::array<std::array<double, 3>, 3> A_{};
  std::array<double, 3> b_{};
  std::map<mapping::BlockKey, const mapping::SubmapBlock*> blocks_;
  std::map<mapping::BlockKey, mapping::Voxel*> asked_;
  bool exact_ = true;
};

}  // namespace onemap::test
