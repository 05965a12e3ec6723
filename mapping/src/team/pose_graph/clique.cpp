#include "clique.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace onemap::mapping {

namespace {

using Vertices = std::vector<std::size_t>;

std::size_t degree(const AgreementGraph& graph, std::size_t v, const Vertices& among) {
  return static_cast<std::size_t>(
      std::count_if(among.begin(), among.end(), [&](std::size_t u) { return graph.agree(v, u); }));
}

// Those with the most neighbours first: good starts of large groups.
Vertices by_degree(const AgreementGraph& graph, const Vertices& among) {
  std::vector<std::pair<std::size_t, std::size_t>> keyed;
  for (std::size_t v : among) keyed.emplace_back(among.size() - degree(graph, v, among), v);
  std::sort(keyed.begin(), keyed.end());
  Vertices out;
  for (const auto& [key, v] : keyed) out.push_back(v);
  return out;
}

Vertices greedy(const AgreementGraph& graph, const Vertices& among) {
  const Vertices order = by_degree(graph, among);
  Vertices best;
  std::vector<std::uint64_t> agree_with_all(graph.words());
  for (std::size_t start : order) {
    Vertices group;
    std::fill(agree_with_all.begin(), agree_with_all.end(), ~0ull);
    const auto add = [&](std::size_t v) {
      group.push_back(v);
      for (std::size_t w = 0; w < graph.words(); ++w) agree_with_all[w] &= graph.row(v)[w];
    };
    add(start);
    for (std::size_t v : order)
      if (agree_with_all[v / 64] >> (v % 64) & 1) add(v);
    if (group.size() > best.size()) best = group;
  }
  return best;
}

// Without the vertices that cannot be in a group of more than `size`: those with fewer than `size` neighbours left.
Vertices core(const AgreementGraph& graph, Vertices among, std::size_t size) {
  for (std::size_t before = among.size() + 1; among.size() < before;) {
    before = among.size();
    Vertices kept;
    for (std::size_t v : among)
      if (degree(graph, v, among) >= size) kept.push_back(v);
    among = std::move(kept);
  }
  return among;
}

// The exact search among 64 vertices at most, each a bit.
class ExactSearch {
 public:
  ExactSearch(const AgreementGraph& graph, Vertices vertices, std::size_t at_least, std::size_t steps)
      : vertices_(std::move(vertices)), best_size_(at_least), steps_(steps) {
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      for (std::size_t j = 0; j < vertices_.size(); ++j)
        if (graph.agree(vertices_[i], vertices_[j])) neighbours_[i] |= 1ull << j;
  }

  // Empty: none is larger than `at_least`.
  Vertices run() {
    const std::size_t n = vertices_.size();
    expand(n == 64 ? ~0ull : (1ull << n) - 1, 0, 0);
    Vertices out;
    for (std::size_t i = 0; i < n; ++i)
      if (best_ >> i & 1) out.push_back(vertices_[i]);
    return out;
  }

 private:
  struct Coloured {
    std::array<std::uint8_t, 64> vertex{}, colour{};
    std::size_t count = 0;
  };

  // Vertices of one colour do not agree with each other, so a group has one of each colour at most.
  Coloured colour(std::uint64_t candidates) const {
    Coloured out;
    for (std::uint8_t colour = 1; candidates != 0; ++colour) {
      for (std::uint64_t free = candidates; free != 0;) {
        const auto v = static_cast<std::uint8_t>(std::countr_zero(free));
        free &= ~(neighbours_[v] | 1ull << v);
        candidates &= ~(1ull << v);
        out.vertex[out.count] = v;
        out.colour[out.count++] = colour;
      }
    }
    return out;
  }

  void expand(std::uint64_t candidates, std::uint64_t group, std::size_t size) {
    if (candidates == 0) {
      if (size > best_size_) best_size_ = size, best_ = group;
      return;
    }
    const Coloured order = colour(candidates);
    for (std::size_t i = order.count; i-- > 0;) {
      if (size + order.colour[i] <= best_size_ || steps_ == 0) return;
      --steps_;
      const std::uint64_t bit = 1ull << order.vertex[i];
      expand(candidates & neighbours_[order.vertex[i]], group | bit, size + 1);
      candidates &= ~bit;
    }
  }

  Vertices vertices_;
  std::array<std::uint64_t, 64> neighbours_{};
  std::uint64_t best_ = 0;
  std::size_t best_size_, steps_;
};

}  // namespace

std::vector<std::size_t> largest_clique(const AgreementGraph& graph, const std::vector<std::size_t>& among,
                                        std::size_t steps) {
  Vertices best = greedy(graph, among);
  Vertices left = core(graph, among, best.size());
  if (!left.empty() && left.size() <= 64)
    if (Vertices larger = ExactSearch(graph, std::move(left), best.size(), steps).run(); !larger.empty()) best = larger;
  std::sort(best.begin(), best.end());
  return best;
}

}  // namespace onemap::mapping
