#pragma once
#include <cstdint>

#include "mapping/local/local_mapper.hpp"

namespace onemap::test {

// Over every submap that the mapper knows: its anchor and its voxels.
inline std::uint64_t submap_digest(const mapping::LocalMapper& mapper) {
  std::uint64_t digest = 0xcbf29ce484222325u;
  mapper.for_each_submap([&](const mapping::SubmapAnchor& anchor, const mapping::VoxelMap& voxels) {
    for (const std::uint64_t part : {std::uint64_t{anchor.keyframe}, voxels.digest()})
      digest = (digest ^ part) * 0x100000001b3u;
  });
  return digest;
}

}  // namespace onemap::test
