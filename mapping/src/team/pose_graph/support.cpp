#include <algorithm>
#include <optional>

#include "joining.hpp"

namespace onemap::mapping {

namespace {

using Points = std::vector<Vector3d>;

// The anchors of a chain that links could be looked for at, [first, end) of the index.
struct Way {
  std::size_t first = 0, end = 0;
};
Way way_of(const GraphIndex& index, std::size_t chain, std::uint32_t last_keyframe) {
  Way out{index.chains[chain].first, index.chains[chain].first};
  while (out.end < out.first + index.chains[chain].count && index.ids[out.end].keyframe <= last_keyframe) ++out.end;
  return out;
}

double farthest(const ChainFrames& frames, const Way& way, const Vector3d& from) {
  double squared = 0;
  for (std::size_t i = way.first; i < way.end; ++i)
    squared = std::max(squared, (frames.T_chain_anchor[i].t - from).squaredNorm());
  return std::sqrt(squared);
}

// Of the anchors, how many are near one of the points.
double share_near(const ChainFrames& frames, const Way& way, const Points& points, double near_m) {
  std::size_t near = 0;
  for (std::size_t i = way.first; i < way.end; ++i)
    near += std::ranges::any_of(points, [&](const Vector3d& point) {
      return (frames.T_chain_anchor[i].t - point).squaredNorm() < near_m * near_m;
    });
  return static_cast<double>(near) / static_cast<double>(way.end - way.first);
}

// From every link on, what is far from all that was taken, until a start gives enough. For two places it is exact.
std::size_t count_apart(const Points& a, const Points& b, double apart_m, std::size_t enough) {
  const auto apart = [&](std::size_t x, std::size_t y) {
    return (a[x] - a[y]).squaredNorm() >= apart_m * apart_m && (b[x] - b[y]).squaredNorm() >= apart_m * apart_m;
  };
  std::size_t most = 0;
  for (std::size_t start = 0; start < a.size() && most < enough; ++start) {
    std::vector<std::size_t> taken{start};
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::ranges::all_of(taken, [&](std::size_t t) { return apart(i, t); })) taken.push_back(i);
    most = std::max(most, taken.size());
  }
  return most;
}

// An anchor of chain a where the link that stands for all lays one of chain b, looking the same way: the two cameras
// see one thing, if the link is right.
struct Beside {
  Vector3d a, b;
};
std::vector<Beside> side_by_side(const ChainFrames& frames, const Way& way_a, const Way& way_b, const GraphEdge& link,
                                 const JoinConfig& config) {
  const Pose T_a_b = frames.T_chain_anchor[link.a] * link.T_a_b * frames.T_chain_anchor[link.b].inverse();
  std::vector<Pose> b_in_a;
  b_in_a.reserve(way_b.end - way_b.first);
  for (std::size_t j = way_b.first; j < way_b.end; ++j) b_in_a.push_back(T_a_b * frames.T_chain_anchor[j]);
  std::vector<Beside> out;
  for (std::size_t i = way_a.first; i < way_a.end; ++i) {
    const Pose& at = frames.T_chain_anchor[i];
    double nearest = config.beside_m * config.beside_m;
    std::optional<std::size_t> beside;
    for (std::size_t j = 0; j < b_in_a.size(); ++j)
      if (const double apart = (b_in_a[j].t - at.t).squaredNorm();
          apart < nearest && rotation_cosine(at.R.transpose() * b_in_a[j].R) > config.beside_cosine)
        nearest = apart, beside = j;
    if (beside) out.push_back({at.t, frames.T_chain_anchor[way_b.first + *beside].t});
  }
  return out;
}

// Of what lies side by side, the share that is far from every link, less what would be if as many links were spread at
// random.
double share_missed(const std::vector<Beside>& beside, const Points& a, const Points& b, double near_m) {
  if (beside.empty()) return 0;
  std::vector<bool> missed(beside.size(), true);
  double by_chance = 1;
  for (std::size_t l = 0; l < a.size(); ++l) {
    std::size_t near = 0;
    for (std::size_t i = 0; i < beside.size(); ++i)
      if ((beside[i].a - a[l]).squaredNorm() < near_m * near_m && (beside[i].b - b[l]).squaredNorm() < near_m * near_m)
        ++near, missed[i] = false;
    by_chance *= 1 - static_cast<double>(near) / static_cast<double>(beside.size());
  }
  const auto count = std::count(missed.begin(), missed.end(), true);
  return static_cast<double>(count) / static_cast<double>(beside.size()) - by_chance;
}

}  // namespace

JoinReason support(const JoinConfig& config, const Evidence& evidence) {
  if (evidence.links < config.links) return JoinReason::too_few_links;
  if (evidence.missed > config.most_missed) return JoinReason::unlinked_beside;
  if (evidence.places >= config.places) return JoinReason::joined;
  const bool at_home =
      evidence.links >= config.links_in_one_place && evidence.share_of_way >= config.share_in_one_place;
  return at_home ? JoinReason::joined : JoinReason::one_place;
}

Evidence evidence_of(const GraphIndex& index, const ChainFrames& frames, const std::vector<std::size_t>& links,
                     const JoinConfig& config) {
  Evidence out{.links = static_cast<std::uint32_t>(links.size())};
  if (links.empty()) return out;
  Points a, b;
  std::size_t best = links[0];
  std::uint32_t known_a = 0, known_b = 0;
  for (std::size_t i : links) {
    const IndexedLink& link = index.links[i];
    a.push_back(frames.T_chain_anchor[link.edge.a] * link.link->a.T_anchor_keyframe.t);
    b.push_back(frames.T_chain_anchor[link.edge.b] * link.link->b.T_anchor_keyframe.t);
    if (link.link->inliers > index.links[best].link->inliers) best = i;
    known_a = std::max({known_a, link.link->known_a, link.link->a.anchor});
    known_b = std::max({known_b, link.link->known_b, link.link->b.anchor});
  }
  const Way way_a = way_of(index, index.links[best].chain_a, known_a),
            way_b = way_of(index, index.links[best].chain_b, known_b);
  out.missed = share_missed(side_by_side(frames, way_a, way_b, index.links[best].edge, config), a, b, config.beside_m);
  double apart_m = config.place_distance_m;
  if (out.links < config.links_in_one_place) {  // too few to tell from what lies side by side
    const double way_m = std::min(farthest(frames, way_a, a[0]), farthest(frames, way_b, b[0]));
    apart_m = std::clamp(config.place_share_of_way * way_m, apart_m, config.most_place_distance_m);
  }
  out.places = static_cast<std::uint32_t>(count_apart(a, b, apart_m, config.places));
  if (out.places < config.places)
    out.share_of_way = std::max(share_near(frames, way_a, a, config.place_distance_m),
                                share_near(frames, way_b, b, config.place_distance_m));
  return out;
}

}  // namespace onemap::mapping
