#include <algorithm>

#include "joining.hpp"

namespace onemap::mapping {

JoinReason support(const JoinConfig& config, std::uint32_t links, std::uint32_t places) {
  if (links < config.links) return JoinReason::too_few_links;
  return places >= config.places || links >= config.links_in_one_place ? JoinReason::joined : JoinReason::one_place;
}

std::uint32_t count_places(const GraphIndex& index, const ChainFrames& frames, const std::vector<std::size_t>& links,
                           const JoinConfig& config) {
  std::vector<std::pair<Vector3d, Vector3d>> ends;
  for (std::size_t i : links) {
    const IndexedLink& link = index.links[i];
    ends.emplace_back(frames.T_chain_anchor[link.edge.a] * link.link->a.T_anchor_keyframe.t,
                      frames.T_chain_anchor[link.edge.b] * link.link->b.T_anchor_keyframe.t);
  }
  const auto apart = [&](const auto& x, const auto& y) {
    return (x.first - y.first).norm() >= config.place_distance_m &&
           (x.second - y.second).norm() >= config.place_distance_m;
  };
  // From every link on, what is far from all that was taken, until a start gives enough. For two places it is exact.
  std::size_t most = 0;
  for (std::size_t start = 0; start < ends.size() && most < config.places; ++start) {
    std::vector<std::size_t> taken{start};
    for (std::size_t i = 0; i < ends.size(); ++i)
      if (std::all_of(taken.begin(), taken.end(), [&](std::size_t t) { return apart(ends[i], ends[t]); }))
        taken.push_back(i);
    most = std::max(most, taken.size());
  }
  return static_cast<std::uint32_t>(most);
}

}  // namespace onemap::mapping
