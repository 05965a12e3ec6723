#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace onemap::mapping::marching_cubes {

// Corner c of a cell lies at (c & 1, (c >> 1) & 1, (c >> 2) & 1). Edge 4 * axis + k starts at the k-th of the four
// corners whose coordinate on that axis is 0.
struct Edge {
  int corner = 0, axis = 0;
};

// The triangles of one case (bit c set: corner c is inside the solid), as edges, three a triangle, counter-clockwise
// seen from outside.
struct Case {
  int edges = 0;  // used entries
  std::array<std::uint8_t, 36> edge{};
};

constexpr std::size_t kEdges = 12;

constexpr std::array<Edge, kEdges> make_edges() {
  std::array<Edge, kEdges> out{};
  std::size_t n = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 8; ++corner)
      if (((corner >> axis) & 1) == 0) out[n++] = {corner, axis};
  return out;
}
inline constexpr std::array<Edge, kEdges> kEdge = make_edges();

// The edge between two corners that differ on one axis.
constexpr int edge_between(int a, int b) {
  const int lower = a < b ? a : b;
  for (std::size_t e = 0; e < kEdges; ++e)
    if (kEdge[e].corner == lower && (lower | (1 << kEdge[e].axis)) == (a < b ? b : a)) return static_cast<int>(e);
  return -1;
}

// On each face, walked counter-clockwise seen from outside the cell, the surface runs from where the walk enters the
// solid to where it leaves it. So every run of inside corners is cut off by itself, which the neighbour that shares the
// face decides likewise: no holes. The segments of all faces close to loops, and loops become fans.
constexpr Case make_case(unsigned inside) {
  const auto in = [inside](int corner) { return ((inside >> corner) & 1) != 0; };
  std::array<int, kEdges> next{};
  for (int& e : next) e = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const int b = 1 << ((axis + 1) % 3), c = 1 << ((axis + 2) % 3);
    for (int side = 0; side < 2; ++side) {
      const int base = side << axis;
      const std::array<int, 4> walk = side == 1 ? std::array{base, base | b, base | b | c, base | c}
                                                : std::array{base, base | c, base | b | c, base | b};
      for (std::size_t i = 0; i < 4; ++i) {
        if (in(walk[i]) || !in(walk[(i + 1) % 4])) continue;
        std::size_t last = (i + 1) % 4;
        while (in(walk[(last + 1) % 4])) last = (last + 1) % 4;
        next[static_cast<std::size_t>(edge_between(walk[i], walk[(i + 1) % 4]))] =
            edge_between(walk[last], walk[(last + 1) % 4]);
      }
    }
  }
  Case out;
  for (std::size_t first = 0; first < kEdges; ++first) {
    if (next[first] < 0) continue;
    auto second = static_cast<std::size_t>(next[first]);
    next[first] = -1;
    while (next[second] >= 0 && static_cast<std::size_t>(next[second]) != first) {
      const auto third = static_cast<std::size_t>(next[second]);
      next[second] = -1;
      for (const std::size_t e : {first, second, third})
        out.edge[static_cast<std::size_t>(out.edges++)] = static_cast<std::uint8_t>(e);
      second = third;
    }
    next[second] = -1;
  }
  return out;
}

constexpr std::array<Case, 256> make_cases() {
  std::array<Case, 256> out{};
  for (unsigned i = 0; i < 256; ++i) out[i] = make_case(i);
  return out;
}

}  // namespace onemap::mapping::marching_cubes
