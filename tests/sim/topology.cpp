#include "sim/topology.hpp"

#include <algorithm>

namespace onemap::comms::sim {

std::vector<Edge> line(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i + 1 < n; ++i) edges.emplace_back(i, i + 1);
  return edges;
}

std::vector<Edge> ring(std::size_t n) {
  auto edges = line(n);
  if (n > 2) edges.emplace_back(0, n - 1);
  return edges;
}

std::vector<Edge> star(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 1; i < n; ++i) edges.emplace_back(0, i);
  return edges;
}

std::vector<Edge> complete(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) edges.emplace_back(i, j);
  return edges;
}

std::vector<Edge> connected(std::size_t n, std::size_t more, Random& random) {
  std::vector<Edge> edges;
  for (std::size_t i = 1; i < n; ++i) edges.emplace_back(random.below(i), i);
  for (; more > 0 && n > 1; --more) {
    const std::size_t a = random.below(n), b = random.below(n);
    if (a != b) edges.push_back(std::minmax(a, b));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

std::vector<int> distances(std::size_t n, const std::vector<Edge>& edges, std::size_t from) {
  std::vector<std::vector<std::size_t>> neighbours(n);
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::vector<int> distance(n, -1);
  distance[from] = 0;
  std::vector<std::size_t> queue{from};
  for (std::size_t next = 0; next < queue.size(); ++next)
    for (const std::size_t to : neighbours[queue[next]]) {
      if (distance[to] >= 0) continue;
      distance[to] = distance[queue[next]] + 1;
      queue.push_back(to);
    }
  return distance;
}

}  // namespace onemap::comms::sim
