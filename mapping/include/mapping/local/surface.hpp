#pragma once
#include <memory>
#include <span>
#include <vector>

#include "mapping/local/voxel_map.hpp"
#include "mapping/mesh.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// Marching cubes (Lorensen and Cline 1987) over the zero level of the map; shared vertices are welded; colour and
// normal are interpolated; where an edge has no coloured end, its neighbours say the colour. Voxels with less than
// min_weight do not count; one that is not seen is guessed where its direct neighbours say what a plane has there, so
// that grazing surfaces and rims close. Deterministic: the order follows the sorted blocks.
TriangleMesh extract_mesh(const VoxelMap& map, std::uint16_t min_weight = 2);
// The same of blocks as they are saved, sorted by key, none twice: without a map, which takes twice their memory.
TriangleMesh extract_mesh(std::span<const SubmapBlock* const> blocks, float voxel_m, std::uint16_t min_weight = 2);

// The same of blocks that come in their order, of which it keeps those alone that the next ones lie beside: a tenth of
// a house.
class BlockMesher {
 public:
  explicit BlockMesher(float voxel_m, std::uint16_t min_weight = 2);
  BlockMesher(BlockMesher&&) noexcept;
  BlockMesher& operator=(BlockMesher&&) noexcept;
  ~BlockMesher();
  bool add(std::vector<SubmapBlock> blocks);  // false: they are not sorted by key, or not behind those before
  TriangleMesh take();                        // once all were added

 private:
  class Window;
  std::unique_ptr<Window> window_;
};

}  // namespace onemap::mapping
