#include "start_poses.hpp"

#include <algorithm>
#include <map>

namespace onemap::mapping {

namespace {

// A chain by itself: its anchors in some frame, which is that of a component in use, or the chain's own.
struct Shape {
  std::vector<Pose> poses;
  std::optional<std::uint32_t> component;
};

Shape shape_of(const ChainFrames& frames, const IndexedChain& chain, const InUse& in_use) {
  Shape out;
  const auto step_to = [&](std::size_t i) {
    const std::size_t anchor = chain.first + i;
    return frames.T_chain_anchor[anchor - 1].inverse() * frames.T_chain_anchor[anchor];
  };
  std::optional<std::size_t> known;  // the first anchor with a pose in use
  for (std::size_t i = 0; i < chain.count; ++i) {
    const auto& placed = in_use.anchors[chain.first + i];
    if (placed && !known) known = i, out.component = placed->component;
    out.poses.push_back(placed   ? from_quantized(placed->pose)
                        : i == 0 ? frames.T_chain_anchor[chain.first]
                                 : out.poses.back() * step_to(i));
    out.poses.back().R = orthonormal(out.poses.back().R);
  }
  for (std::size_t i = known.value_or(0); i-- > 0;) out.poses[i] = out.poses[i + 1] * step_to(i + 1).inverse();
  return out;
}

class Layout {
 public:
  Layout(const GraphIndex& index, const ChainFrames& frames, const ChainGroup& group, const InUse& in_use)
      : index_(index) {
    for (std::size_t chain : group.chains) shapes_[chain] = shape_of(frames, index.chains[chain], in_use);
  }

  void lay(std::size_t chain, const Pose& T_map_shape) {
    for (Pose& pose : shapes_[chain].poses) pose = T_map_shape * pose;
    laid_[chain] = true;
  }
  bool laid(std::size_t chain) const { return laid_.contains(chain); }
  const Shape& shape(std::size_t chain) const { return shapes_.at(chain); }
  const Pose& pose(std::size_t anchor) const {
    const std::size_t chain = index_.chain_of[anchor];
    return shapes_.at(chain).poses[anchor - index_.chains[chain].first];
  }

  // Along the link from the end that lies to the other one. False: both lie, or none.
  bool lay_along(const IndexedLink& link) {
    const GraphEdge& edge = link.edge;
    if (laid(link.chain_a) == laid(link.chain_b)) return false;
    if (laid(link.chain_a))
      lay(link.chain_b, pose(edge.a) * edge.T_a_b * pose(edge.b).inverse());
    else
      lay(link.chain_a, pose(edge.b) * edge.T_a_b.inverse() * pose(edge.a).inverse());
    return true;
  }

  std::vector<Pose> poses() const {
    std::vector<Pose> out;
    for (const auto& [chain, shape] : shapes_) out.insert(out.end(), shape.poses.begin(), shape.poses.end());
    return out;
  }

 private:
  const GraphIndex& index_;
  std::map<std::size_t, Shape> shapes_;
  std::map<std::size_t, bool> laid_;
};

}  // namespace

std::size_t reference_of(const GraphIndex& index, const ChainGroup& group, const Joining& joining,
                         const InUse& in_use) {
  for (std::size_t anchor : in_use.references)
    if (std::binary_search(group.chains.begin(), group.chains.end(), index.chain_of[anchor])) return anchor;
  return index.chains[most_matched(group, joining)].first;
}

std::vector<Pose> start_poses(const GraphIndex& index, const ChainFrames& frames, const ChainGroup& group,
                              const Joining& joining, const InUse& in_use, std::size_t reference) {
  Layout layout(index, frames, group, in_use);
  const std::size_t first = index.chain_of[reference];
  const auto frame = layout.shape(first).component;
  for (std::size_t chain : group.chains)
    if (chain == first || (frame && layout.shape(chain).component == frame)) layout.lay(chain, Pose{});
  for (bool more = true; more;) {
    more = false;
    for (std::size_t pair : group.tree) more |= layout.lay_along(index.links[joining.pairs[pair].best]);
  }
  return layout.poses();
}

}  // namespace onemap::mapping
