#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "mapping/team/pose_graph_input.hpp"

// What a pose graph says, complete enough to answer `why` of every link and every chain.
namespace onemap::mapping {

enum class LinkUse : std::uint8_t {
  used,
  no_anchor,          // an end is not in the graph (yet)
  surplus,            // its pair of anchors has enough better ones; number: its rank there, from 1
  contradicts_chain,  // an own loop that odometry rules out; number: chi square
  chains_apart,       // nothing joins its two chains
  outlier,            // the graph that holds its ends rules it out; number: its squared error in sigmas
};
std::string_view to_string(LinkUse use);

struct LinkVerdict {
  LinkId id;
  LinkUse use = LinkUse::used;
  double number = 0;  // used: its squared error in sigmas
};

enum class JoinReason : std::uint8_t {
  joined,
  no_links,
  too_few_links,       // that agree; number: how many do
  one_place,           // they agree, and are all from one place; number: how many agree
  unlinked_beside,     // they lay much side by side that no link is between; number: how many agree
  look_alike,          // a second group contradicts the first; number: links of the second
  contradicts_others,  // rings over third chains do not close; number: links that are against it
  contradicts_graph,  // they agree with each other, and the rest of the graph rules them out; number: how many are left
};
std::string_view to_string(JoinReason reason);

// What the links between two chains are worth (a < b), or the own loops of one (a == b).
struct PairVerdict {
  ChainId a, b;
  JoinReason reason = JoinReason::no_links;
  double number = 0;  // as the reason says; joined: links that agree
  std::uint32_t links = 0, agree = 0, places = 0,
                second = 0;  // compared, largest group, its places, largest that contradicts
  std::uint32_t used = 0;    // links of the pair in use
};

// Chains that are joined, directly or through others, and share a frame.
struct GraphComponent {
  std::vector<ChainId> chains;  // sorted
  AnchorId reference;           // keeps its pose: the frame of the component hangs on it
  // Why it is not part of the first component: what the best pair towards it lacks. The first: joined.
  JoinReason reason = JoinReason::joined;
  double number = 0;
  std::uint32_t anchors = 0;
};

struct SolvedAnchor {
  AnchorId id;
  std::uint32_t component = 0;
  QuantizedPose T_map_anchor;  // map: the frame of its component
  bool moved = true;           // new, or another pose than the one in use
};

// Solving's effort: for budgets and benchmarks.
struct SolveEffort {
  std::uint32_t rounds = 0;          // of graduated non-convexity, over all components
  std::uint32_t factorisations = 0;  // of the normal equations
  std::uint32_t pairs_compared = 0;  // of links
  bool converged = true;             // every component's last step was small
};

struct GraphSolution {
  std::vector<GraphComponent> components;  // the first is the team's map: most chains, then lowest id
  std::vector<SolvedAnchor> anchors;       // all, sorted by id
  std::vector<LinkVerdict> links;          // all, sorted by id
  std::vector<PairVerdict> pairs;          // with at least one link, sorted
  bool changed = false;                    // against the one in use: an anchor, a link's use or a component
  SolveEffort effort;

  const SolvedAnchor* find(const AnchorId& id) const;  // nullptr: not in the graph
  const LinkVerdict* find(const LinkId& id) const;
};

}  // namespace onemap::mapping
