#include "render/tidy.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace onemap::render {
namespace {

using mapping::TriangleMesh;
constexpr std::uint32_t kNone = 0xFFFFFFFFu;
constexpr int kRings = 8;  // how far colour spreads

bool possible(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  return std::ranges::all_of(triangle, [&](std::uint32_t i) { return i < mesh.vertices.size(); });
}

// The connected pieces of a mesh: disjoint sets of vertices with path halving, of which the lowest vertex is the root.
class Pieces {
 public:
  explicit Pieces(const TriangleMesh& mesh) : root_(mesh.vertices.size()), size_(mesh.vertices.size(), 0) {
    std::iota(root_.begin(), root_.end(), 0u);
    for (const auto& triangle : mesh.triangles)
      if (possible(mesh, triangle)) join(triangle);
    for (std::uint32_t i = 0; i < root_.size(); ++i) {
      root_[i] = root_[root_[i]];  // a lower one, of which this was done
      ++size_[root_[i]];
    }
  }
  std::size_t size_of(std::uint32_t vertex) const { return size_[root_[vertex]]; }
  std::size_t largest() const { return size_.empty() ? 0 : *std::max_element(size_.begin(), size_.end()); }

 private:
  std::uint32_t root(std::uint32_t i) {
    while (root_[i] != i) i = root_[i] = root_[root_[i]];
    return i;
  }
  void join(const std::array<std::uint32_t, 3>& triangle) {
    const std::uint32_t a = root(triangle[0]), b = root(triangle[1]), c = root(triangle[2]);
    const std::uint32_t lowest = std::min({a, b, c});
    root_[a] = root_[b] = root_[c] = lowest;
  }
  std::vector<std::uint32_t> root_, size_;
};

// Where each vertex goes; kNone: nowhere. One alone is in no triangle, or in one that has it only.
std::vector<std::uint32_t> new_places(const TriangleMesh& mesh, std::size_t smallest_piece) {
  const Pieces pieces(mesh);
  const std::size_t least = std::max<std::size_t>(std::min(smallest_piece, pieces.largest()), 2);
  std::vector<std::uint32_t> places(mesh.vertices.size());
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < places.size(); ++i) places[i] = pieces.size_of(i) >= least ? next++ : kNone;
  return places;
}

// In place: these arrays are most of what a map is.
template <class T>
void keep(std::vector<T>& values, const std::vector<std::uint32_t>& places) {
  if (values.size() != places.size()) return;  // none, or a torn mesh: whoever draws or writes it says so
  std::size_t count = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (places[i] != kNone) values[count++] = values[i];
  values.resize(count);
}

bool black(const mapping::Rgb& c) { return (c[0] | c[1] | c[2]) == 0; }

struct Sum {
  std::array<std::uint32_t, 3> rgb{};
  std::uint32_t count = 0;
  void add(const mapping::Rgb& c) {
    for (std::size_t i = 0; i < 3; ++i) rgb[i] += c[i];
    ++count;
  }
  mapping::Rgb mean() const {
    mapping::Rgb out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<std::uint8_t>((rgb[i] + count / 2) / count);
    return out;
  }
};

// One ring further; says whether anything changed.
bool spread(TriangleMesh& mesh, std::vector<Sum>& sums) {
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!black(mesh.colors[triangle[k]])) continue;
      for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3})
        if (!black(mesh.colors[triangle[other]])) sums[triangle[k]].add(mesh.colors[triangle[other]]);
    }
  }
  bool changed = false;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].count == 0) continue;
    mesh.colors[i] = sums[i].mean();
    sums[i] = {};
    changed = true;
  }
  return changed;
}

}  // namespace

TriangleMesh without_crumbs(TriangleMesh mesh, std::size_t smallest_piece) {
  if (mesh.triangles.empty()) return mesh;
  const std::vector<std::uint32_t> places = new_places(mesh, smallest_piece);
  std::erase_if(mesh.triangles, [&](const auto& t) { return !possible(mesh, t) || places[t[0]] == kNone; });
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& vertex : triangle) vertex = places[vertex];
  keep(mesh.vertices, places);
  keep(mesh.normals, places);
  keep(mesh.colors, places);
  return mesh;
}

void colour_black_vertices(TriangleMesh& mesh) {
  if (mesh.colors.size() != mesh.vertices.size()) return;
  if (!std::ranges::all_of(mesh.triangles, [&](const auto& t) { return possible(mesh, t); })) return;
  if (std::ranges::none_of(mesh.colors, black)) return;
  std::vector<Sum> sums(mesh.colors.size());
  for (int ring = 0; ring < kRings && spread(mesh, sums); ++ring) {
  }
}

TriangleMesh tidied(TriangleMesh mesh, std::size_t smallest_piece) {
  mesh = without_crumbs(std::move(mesh), smallest_piece);
  colour_black_vertices(mesh);
  return mesh;
}

}  // namespace onemap::render
