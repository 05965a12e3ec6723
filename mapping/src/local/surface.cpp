#include "mapping/local/surface.hpp"

#include <cmath>
#include <map>

#include "local/block_samples.hpp"
#include "local/marching_cubes_table.hpp"

namespace onemap::mapping {
namespace {

namespace mc = marching_cubes;
constexpr std::array<mc::Case, 256> kCases = mc::make_cases();

// Between neighbouring voxels the distance changes by voxel / truncation, a third, over the cosine of incidence: 1.5 at
// 77 degrees. A larger step is no surface: there the band behind one surface meets the band before another.
constexpr float kLargestStep = 1.5f;

struct Vertex {
  Vector3f point, normal;
  Rgb color{};
};

struct Crossing {
  int x, y, z, axis;  // from voxel (x, y, z) of the block to the next along the axis
};

bool crosses(const BlockSamples& block, const Crossing& c, float& a, float& b) {
  a = block.tsdf(c.x, c.y, c.z);
  b = block.tsdf(c.x + (c.axis == 0), c.y + (c.axis == 1), c.z + (c.axis == 2));
  return (a < 0) != (b < 0);
}

Rgb mix(const Voxel* a, const Voxel* b, float t) {
  const Rgb ca = a == nullptr ? Rgb{} : a->color(), cb = b == nullptr ? Rgb{} : b->color();
  if (a == nullptr || a->color_weight == 0) return cb;
  if (b == nullptr || b->color_weight == 0) return ca;
  Rgb out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(
        std::lround(static_cast<float>(ca[i]) + t * (static_cast<float>(cb[i]) - static_cast<float>(ca[i]))));
  return out;
}

Vertex vertex_at(const BlockSamples& block, const Crossing& c, float voxel_m) {
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
  out.color = mix(block.voxel(c.x, c.y, c.z), block.voxel(x1, y1, z1), t);
  return out;
}

// Vertex numbers by the edges that they lie on. A cell uses edges of its own and the upper neighbours' blocks, and
// blocks come sorted by x, so numbers are kept for two layers of blocks only.
class VertexIds {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::uint32_t& at(const BlockKey& block, const Crossing& c) {
    const int m = kBlockSide - 1;
    const BlockKey key{block.x + (c.x >> 3), block.y + (c.y >> 3), block.z + (c.z >> 3)};
    if (key != last_key_ || last_ == nullptr) {
      last_ = &ids_[key];
      last_key_ = key;
      if (last_->empty()) last_->assign(3 * kBlockVoxels, kNone);
    }
    return (
        *last_)[static_cast<std::size_t>((((c.z & m) * kBlockSide + (c.y & m)) * kBlockSide + (c.x & m)) * 3 + c.axis)];
  }
  void forget_before(std::int32_t x) {
    if (ids_.empty() || ids_.begin()->first.x >= x) return;
    ids_.erase(ids_.begin(), ids_.lower_bound({x, INT32_MIN, INT32_MIN}));
    last_ = nullptr;
  }

 private:
  std::map<BlockKey, std::vector<std::uint32_t>> ids_;
  BlockKey last_key_;
  std::vector<std::uint32_t>* last_ = nullptr;
};

Crossing edge_of(int x, int y, int z, int edge) {
  const mc::Edge& e = mc::kEdge[static_cast<std::size_t>(edge)];
  return {x + (e.corner & 1), y + ((e.corner >> 1) & 1), z + ((e.corner >> 2) & 1), e.axis};
}

class Mesher {
 public:
  explicit Mesher(float voxel_m) : voxel_m_(voxel_m) {}

  void add(const BlockSamples& block) {
    ids_.forget_before(block.key().x);
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x) add_cell(block, x, y, z);
  }
  TriangleMesh take() { return std::move(mesh_); }

 private:
  void add_cell(const BlockSamples& block, int x, int y, int z) {
    unsigned inside = 0;
    for (int c = 0; c < 8; ++c) {
      const int cx = x + (c & 1), cy = y + ((c >> 1) & 1), cz = z + ((c >> 2) & 1);
      if (!block.seen(cx, cy, cz)) return;
      inside |= static_cast<unsigned>(block.inside(cx, cy, cz)) << c;
    }
    const mc::Case& triangles = kCases[inside];
    if (triangles.edges == 0 || has_false_step(block, x, y, z)) return;
    const std::uint8_t* edge = triangles.edge.data();
    for (int i = 0; i < triangles.edges; i += 3) {
      std::array<std::uint32_t, 3> triangle{};
      for (int k = 0; k < 3; ++k) triangle[static_cast<std::size_t>(k)] = vertex(block, edge_of(x, y, z, *edge++));
      mesh_.triangles.push_back(triangle);
    }
  }

  static bool has_false_step(const BlockSamples& block, int x, int y, int z) {
    for (int e = 0; e < static_cast<int>(mc::kEdges); ++e) {
      float a = 0, b = 0;
      if (crosses(block, edge_of(x, y, z, e), a, b) && std::abs(a - b) > kLargestStep) return true;
    }
    return false;
  }

  std::uint32_t vertex(const BlockSamples& block, const Crossing& c) {
    std::uint32_t& id = ids_.at(block.key(), c);
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

}  // namespace

TriangleMesh extract_mesh(const VoxelMap& map, std::uint16_t min_weight) {
  Mesher mesher(map.config().voxel_m);
  BlockSamples samples;
  map.for_each_sorted([&](const BlockView& block) {
    samples.gather(map, block.key, min_weight);
    if (samples.may_cross_zero()) mesher.add(samples);
  });
  return mesher.take();
}

}  // namespace onemap::mapping
