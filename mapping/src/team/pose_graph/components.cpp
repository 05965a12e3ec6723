#include "components.hpp"

#include <algorithm>
#include <numeric>

namespace onemap::mapping {

namespace {

class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  bool unite(std::size_t a, std::size_t b) {  // false: they were together
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<std::size_t> parent_;
};

// Pairs of two chains that are joined, the best supported first.
std::vector<std::size_t> by_support(const Joining& joining) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < joining.pairs.size(); ++i)
    if (joining.pairs[i].joined() && !joining.pairs[i].own()) out.push_back(i);
  std::stable_sort(out.begin(), out.end(), [&](std::size_t x, std::size_t y) {
    const ChainPair &p = joining.pairs[x], &q = joining.pairs[y];
    return p.verdict.agree != q.verdict.agree ? p.verdict.agree > q.verdict.agree : p.inliers > q.inliers;
  });
  return out;
}

}  // namespace

std::vector<ChainGroup> group_chains(const GraphIndex& index, const Joining& joining) {
  const std::vector<std::size_t> pairs = by_support(joining);
  Sets sets(index.chains.size());
  std::vector<bool> tree(joining.pairs.size());
  for (std::size_t pair : pairs) tree[pair] = sets.unite(joining.pairs[pair].chain_a, joining.pairs[pair].chain_b);
  std::vector<ChainGroup> by_root(index.chains.size());
  for (std::size_t chain = 0; chain < index.chains.size(); ++chain) by_root[sets.root(chain)].chains.push_back(chain);
  for (std::size_t pair : pairs) {
    ChainGroup& group = by_root[sets.root(joining.pairs[pair].chain_a)];
    (tree[pair] ? group.tree : group.rings).push_back(pair);
  }
  std::erase_if(by_root, [](const ChainGroup& group) { return group.chains.empty(); });
  std::stable_sort(by_root.begin(), by_root.end(),
                   [](const ChainGroup& x, const ChainGroup& y) { return x.chains.size() > y.chains.size(); });
  return by_root;
}

std::size_t most_matched(const ChainGroup& group, const Joining& joining) {
  std::vector<std::uint64_t> inliers(group.chains.back() + 1);
  for (const auto* pairs : {&group.tree, &group.rings})
    for (std::size_t i : *pairs)
      for (std::size_t chain : {joining.pairs[i].chain_a, joining.pairs[i].chain_b})
        inliers[chain] += joining.pairs[i].inliers;
  return *std::max_element(group.chains.begin(), group.chains.end(),
                           [&](std::size_t x, std::size_t y) { return inliers[x] < inliers[y]; });
}

}  // namespace onemap::mapping
