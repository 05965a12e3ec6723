#include "mapping/local/surface.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "local/block_samples.hpp"
#include "local/marching_cubes_table.hpp"

namespace onemap::mapping {
namespace {

namespace mc = marching_cubes;
constexpr std::array<mc::Case, 256> kCases = mc::make_cases();

// Between neighbouring voxels the distance changes by voxel / truncation, a third, over the cosine of incidence: 1.5 at
// 77 degrees. A larger step may be no surface: where the band behind one surface meets the band before another.
constexpr float kLargestStep = 1.5f;
constexpr std::size_t kVerticesOfABlock = 48;  // on average hardly more: two thirds of a plane through it
constexpr unsigned kCellsOfARow = ((1u << kBlockSide) - 1) << 1;  // of the bits of SampleRow

struct Vertex {
  Vector3f point, normal;
  Rgb color{};
};

struct Crossing {
  int x, y, z, axis;  // from voxel (x, y, z) of the block to the next along the axis
};

template <class V>
bool crosses(const BlockSamples<V>& block, const Crossing& c, float& a, float& b) {
  a = block.tsdf(c.x, c.y, c.z);
  b = block.tsdf(c.x + (c.axis == 0), c.y + (c.axis == 1), c.z + (c.axis == 2));
  return (a < 0) != (b < 0);
}

// Whether the distance, which changes from a to b over the crossing, changes the other way before or behind it: through
// a surface that is seen at a slant it does not, between two surfaces it does.
template <class V>
bool turns_back(const BlockSamples<V>& block, const Crossing& c, float a, float b) {
  const int dx = c.axis == 0 ? 1 : 0, dy = c.axis == 1 ? 1 : 0, dz = c.axis == 2 ? 1 : 0;
  const float sign = b > a ? 1.f : -1.f;
  const int x0 = c.x - dx, y0 = c.y - dy, z0 = c.z - dz, x1 = c.x + 2 * dx, y1 = c.y + 2 * dy, z1 = c.z + 2 * dz;
  return (block.seen(x0, y0, z0) && sign * (a - block.tsdf(x0, y0, z0)) < 0) ||
         (block.seen(x1, y1, z1) && sign * (block.tsdf(x1, y1, z1) - b) < 0);
}

template <class V>
bool colored(const V* voxel) {
  return voxel != nullptr && is_colored(*voxel);
}

Rgb mix(const Rgb& a, const Rgb& b, float t) {
  Rgb out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(
        std::lround(static_cast<float>(a[i]) + t * (static_cast<float>(b[i]) - static_cast<float>(a[i]))));
  return out;
}

// The mean of the coloured voxels next to the edge's ends; black: there is none.
template <class V>
Rgb color_around(const BlockSamples<V>& block, const Crossing& c) {
  std::array<std::uint32_t, 3> sum{};
  std::uint32_t count = 0;
  for (int z = c.z - 1; z <= c.z + 1 + (c.axis == 2); ++z)
    for (int y = c.y - 1; y <= c.y + 1 + (c.axis == 1); ++y)
      for (int x = c.x - 1; x <= c.x + 1 + (c.axis == 0); ++x) {
        const V* voxel = block.voxel(x, y, z);
        if (!colored(voxel)) continue;
        const Rgb color = color_of(*voxel);
        for (std::size_t i = 0; i < 3; ++i) sum[i] += color[i];
        ++count;
      }
  Rgb out{};
  for (std::size_t i = 0; i < 3 && count > 0; ++i) out[i] = static_cast<std::uint8_t>((sum[i] + count / 2) / count);
  return out;
}

template <class V>
Rgb color_of(const BlockSamples<V>& block, const Crossing& c, float t) {
  const V* a = block.voxel(c.x, c.y, c.z);
  const V* b = block.voxel(c.x + (c.axis == 0), c.y + (c.axis == 1), c.z + (c.axis == 2));
  if (colored(a) && colored(b)) return mix(color_of(*a), color_of(*b), t);
  if (colored(a)) return color_of(*a);
  return colored(b) ? color_of(*b) : color_around(block, c);
}

template <class V>
Vertex vertex_at(const BlockSamples<V>& block, const Crossing& c, float voxel_m) {
  float a = 0, b = 0;
  crosses(block, c, a, b);
  const float t = a / (a - b);
  const int x1 = c.x + (c.axis == 0), y1 = c.y + (c.axis == 1), z1 = c.z + (c.axis == 2);
  Vertex out;
  const BlockKey& key = block.key();
  const Vector3d cell(8.0 * key.x + c.x + 0.5, 8.0 * key.y + c.y + 0.5, 8.0 * key.z + c.z + 0.5);
  Vector3d point = cell * static_cast<double>(voxel_m);
  point[c.axis] += static_cast<double>(t * voxel_m);
  out.point = point.cast<float>();
  const Vector3f g0 = block.gradient(c.x, c.y, c.z), g1 = block.gradient(x1, y1, z1);
  Vector3f g = g0 + t * (g1 - g0);
  const float length = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  if (length > 1e-6f) {
    out.normal = g / length;
  } else {
    out.normal = Vector3f::Zero();
    out.normal[c.axis] = b > a ? 1.f : -1.f;
  }
  out.color = color_of(block, c, t);
  return out;
}

// Vertex numbers by the edges that they lie on. A cell uses edges of its own and the upper neighbours' blocks, and
// blocks come sorted by x, so numbers are kept for two layers of blocks only.
class VertexIds {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  // at() is of this block and its upper neighbours from now on.
  void enter(const BlockKey& block) {
    if (!ids_.empty() && ids_.begin()->first.x < block.x) forget_before(block.x);
    block_ = block;
    near_.fill(nullptr);
  }
  std::uint32_t& at(const Crossing& c) {
    const int m = kBlockSide - 1;
    const std::array<int, 3> step{c.x >> 3, c.y >> 3, c.z >> 3};
    Ids*& ids = near_[static_cast<std::size_t>(step[0] | step[1] << 1 | step[2] << 2)];
    if (ids == nullptr) ids = &ids_of({block_.x + step[0], block_.y + step[1], block_.z + step[2]});
    return (
        *ids)[static_cast<std::size_t>((((c.z & m) * kBlockSide + (c.y & m)) * kBlockSide + (c.x & m)) * 3 + c.axis)];
  }

 private:
  using Ids = std::array<std::uint32_t, 3 * kBlockVoxels>;
  Ids& ids_of(const BlockKey& key) {
    auto& ids = ids_[key];
    if (ids != nullptr) return *ids;
    if (unused_.empty()) unused_.push_back(std::make_unique<Ids>());
    ids = std::move(unused_.back());
    unused_.pop_back();
    ids->fill(kNone);
    return *ids;
  }
  void forget_before(std::int32_t x) {
    const auto end = ids_.lower_bound({x, INT32_MIN, INT32_MIN});
    for (auto at = ids_.begin(); at != end; ++at) unused_.push_back(std::move(at->second));
    ids_.erase(ids_.begin(), end);
  }

  std::map<BlockKey, std::unique_ptr<Ids>> ids_;
  std::vector<std::unique_ptr<Ids>> unused_;
  BlockKey block_;
  std::array<Ids*, 8> near_{};  // of this block and its upper neighbours, once asked for
};

Crossing edge_of(int x, int y, int z, int edge) {
  const mc::Edge& e = mc::kEdge[static_cast<std::size_t>(edge)];
  return {x + (e.corner & 1), y + ((e.corner >> 1) & 1), z + ((e.corner >> 2) & 1), e.axis};
}

template <class V>
class Mesher {
  using Samples = BlockSamples<V>;

 public:
  // Room for the usual number of vertices, which costs nothing where it is not written.
  Mesher(float voxel_m, std::size_t blocks) : voxel_m_(voxel_m) {
    mesh_.vertices.reserve(kVerticesOfABlock * blocks);
    mesh_.normals.reserve(kVerticesOfABlock * blocks);
    mesh_.colors.reserve(kVerticesOfABlock * blocks);
    mesh_.triangles.reserve(2 * kVerticesOfABlock * blocks);
  }

  void add(const Samples& block) {
    ids_.enter(block.key());
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y) add_cells(block, y, z);
  }
  TriangleMesh take() { return std::move(mesh_); }

 private:
  // The row of cells above (0..7, y, z), of which those count that are seen, and neither inside nor outside as a whole.
  void add_cells(const Samples& block, int y, int z) {
    const std::array<SampleRow, 4> rows{block.row(y, z), block.row(y + 1, z), block.row(y, z + 1),
                                        block.row(y + 1, z + 1)};
    const auto all = [&](auto bits) { return bits(rows[0]) & bits(rows[1]) & bits(rows[2]) & bits(rows[3]); };
    const unsigned seen = all([](const SampleRow& row) -> unsigned { return row.seen; });
    const unsigned inside = all([](const SampleRow& row) -> unsigned { return row.inside; });
    const unsigned outside = all([](const SampleRow& row) -> unsigned { return row.seen & ~row.inside; });
    const auto both = [](unsigned bits) { return bits & bits >> 1; };
    unsigned cells = both(seen) & ~both(inside) & ~both(outside) & kCellsOfARow;
    for (; cells != 0; cells &= cells - 1) {
      const int bit = std::countr_zero(cells);
      unsigned corners = 0;
      for (unsigned i = 0; i < 4; ++i) corners |= (static_cast<unsigned>(rows[i].inside) >> bit & 3u) << 2 * i;
      add_cell(block, bit - 1, y, z, kCases[corners]);
    }
  }

  void add_cell(const Samples& block, int x, int y, int z, const mc::Case& triangles) {
    if (has_false_step(block, x, y, z)) return;
    const std::uint8_t* edge = triangles.edge.data();
    for (int i = 0; i < triangles.edges; i += 3) {
      std::array<std::uint32_t, 3> triangle{};
      for (int k = 0; k < 3; ++k) triangle[static_cast<std::size_t>(k)] = vertex(block, edge_of(x, y, z, *edge++));
      mesh_.triangles.push_back(triangle);
    }
  }

  static bool has_false_step(const Samples& block, int x, int y, int z) {
    float least = 1, most = -1;
    for (int c = 0; c < 8; ++c) {
      const float value = block.tsdf(x + (c & 1), y + ((c >> 1) & 1), z + ((c >> 2) & 1));
      least = std::min(least, value);
      most = std::max(most, value);
    }
    if (most - least <= kLargestStep) return false;  // mostly
    for (int e = 0; e < static_cast<int>(mc::kEdges); ++e) {
      const Crossing c = edge_of(x, y, z, e);
      float a = 0, b = 0;
      if (crosses(block, c, a, b) && std::abs(a - b) > kLargestStep && turns_back(block, c, a, b)) return true;
    }
    return false;
  }

  std::uint32_t vertex(const Samples& block, const Crossing& c) {
    std::uint32_t& id = ids_.at(c);
    if (id != VertexIds::kNone) return id;
    id = static_cast<std::uint32_t>(mesh_.vertices.size());
    const Vertex v = vertex_at(block, c, voxel_m_);
    mesh_.vertices.push_back(v.point);
    mesh_.normals.push_back(v.normal);
    mesh_.colors.push_back(v.color);
    return id;
  }

  float voxel_m_;
  VertexIds ids_;
  TriangleMesh mesh_;
};

// The blocks around each block of a sorted list, in its order: those at one offset along x and y come in that order,
// too, so nothing is looked for.
class NeighbourWalk {
 public:
  explicit NeighbourWalk(std::span<const SubmapBlock* const> blocks) : blocks_(blocks) {}

  const BlockSamples<SubmapVoxel>::Neighbours& around(const BlockKey& key) {
    near_.fill(nullptr);
    for (std::size_t column = 0; column < next_.size(); ++column) {
      const auto dx = static_cast<std::int32_t>(column % 3) - 1, dy = static_cast<std::int32_t>(column / 3) - 1;
      const BlockKey first{key.x + dx, key.y + dy, key.z - 1}, last{first.x, first.y, key.z + 1};
      std::size_t& next = next_[column];
      while (next < blocks_.size() && blocks_[next]->key < first) ++next;
      for (std::size_t i = next; i < blocks_.size() && blocks_[i]->key <= last; ++i)
        near_[9 * static_cast<std::size_t>(blocks_[i]->key.z - first.z) + column] = blocks_[i]->voxels.data();
    }
    return near_;
  }

 private:
  std::span<const SubmapBlock* const> blocks_;
  std::array<std::size_t, 9> next_{};
  BlockSamples<SubmapVoxel>::Neighbours near_{};
};

}  // namespace

TriangleMesh extract_mesh(const VoxelMap& map, std::uint16_t min_weight) {
  Mesher<Voxel> mesher(map.config().voxel_m, map.used());
  BlockSamples<Voxel> samples;
  BlockSamples<Voxel>::Neighbours near{};
  map.for_each_sorted([&](const BlockView& block) {
    std::size_t i = 0;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) near[i++] = map.find({block.key.x + x, block.key.y + y, block.key.z + z});
    samples.gather(block.key, near, min_weight);
    if (samples.may_cross_zero()) mesher.add(samples);
  });
  return mesher.take();
}

TriangleMesh extract_mesh(std::span<const SubmapBlock* const> blocks, float voxel_m, std::uint16_t min_weight) {
  Mesher<SubmapVoxel> mesher(voxel_m, blocks.size());
  BlockSamples<SubmapVoxel> samples;
  NeighbourWalk walk(blocks);
  for (const SubmapBlock* block : blocks) {
    samples.gather(block->key, walk.around(block->key), min_weight);
    if (samples.may_cross_zero()) mesher.add(samples);
  }
  return mesher.take();
}

// The last blocks that were added; the first `done_` of them are in the mesh.
class BlockMesher::Window {
 public:
  Window(float voxel_m, std::uint16_t min_weight) : mesher_(voxel_m, kUsualBlocks), min_weight_(min_weight) {}

  bool add(std::vector<SubmapBlock> blocks) {
    const BlockKey* last = blocks_.empty() ? nullptr : &blocks_.back()->key;
    for (const SubmapBlock& block : blocks) {
      if (last != nullptr && !(*last < block.key)) return false;
      last = &block.key;
    }
    for (const SubmapBlock& block : blocks) blocks_.push_back(&block);
    if (!blocks.empty()) added_.push_back(std::move(blocks));
    // Of one layer along x the next one must be there, and of the next but one a block, so that nothing more comes.
    if (!blocks_.empty()) mesh_before(blocks_.back()->key.x - 1);
    return true;
  }
  TriangleMesh take() {
    mesh_before(INT32_MAX);
    return mesher_.take();
  }

 private:
  static constexpr std::size_t kUsualBlocks = 20000;

  void mesh_before(std::int32_t x) {
    const std::size_t begin = done_;
    while (done_ < blocks_.size() && blocks_[done_]->key.x < x) ++done_;
    if (done_ == begin) return;
    NeighbourWalk walk(blocks_);
    for (std::size_t i = begin; i < done_; ++i) {
      samples_.gather(blocks_[i]->key, walk.around(blocks_[i]->key), min_weight_);
      if (samples_.may_cross_zero()) mesher_.add(samples_);
    }
    forget_before(x - 1);
  }
  void forget_before(std::int32_t x) {
    std::size_t gone = 0;
    for (; !added_.empty() && added_.front().back().key.x < x; added_.pop_front()) gone += added_.front().size();
    blocks_.erase(blocks_.begin(), blocks_.begin() + static_cast<std::ptrdiff_t>(gone));
    done_ -= gone;
  }

  Mesher<SubmapVoxel> mesher_;
  const std::uint16_t min_weight_;
  BlockSamples<SubmapVoxel> samples_;
  std::deque<std::vector<SubmapBlock>> added_;
  std::vector<const SubmapBlock*> blocks_;  // of `added_`
  std::size_t done_ = 0;
};

BlockMesher::BlockMesher(float voxel_m, std::uint16_t min_weight)
    : window_(std::make_unique<Window>(voxel_m, min_weight)) {}
BlockMesher::BlockMesher(BlockMesher&&) noexcept = default;
BlockMesher& BlockMesher::operator=(BlockMesher&&) noexcept = default;
BlockMesher::~BlockMesher() = default;
bool BlockMesher::add(std::vector<SubmapBlock> blocks) { return window_->add(std::move(blocks)); }
TriangleMesh BlockMesher::take() { return window_->take(); }

}  // namespace onemap::mapping
