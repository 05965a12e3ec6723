#include "mapping/team/pose_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "pose_graph_lines.hpp"
#include "pose_graph_team.hpp"

namespace onemap::mapping {
namespace {

using test::PoseGraphTeam;

using namespace test_lines;

Pose pose_of(const GraphSolution& solution, const char* chain, std::uint32_t keyframe) {
  const SolvedAnchor* anchor = solution.find(AnchorId{chain_id(chain), keyframe});
  if (anchor == nullptr) ADD_FAILURE() << chain << keyframe << " is not in the solution";
  return anchor ? from_quantized(anchor->T_map_anchor) : Pose{};
}

const PairVerdict& only_pair(const GraphSolution& solution) {
  EXPECT_EQ(solution.pairs.size(), 1u);
  return solution.pairs.front();
}

TEST(PoseGraph, AChainAloneIsItsOdometryFromItsFirstPose) {
  PoseGraph graph;
  std::vector<ChainAnchor> anchors = line(3);
  anchors[0].T_previous_anchor = shift(5, 6, 7);
  ASSERT_TRUE(graph.set_chain(chain_id("a"), anchors));
  const GraphSolution solution = graph.solve();
  EXPECT_LT((pose_of(solution, "a", 2).t - Vector3d(7, 6, 7)).norm(), 1e-9);
  ASSERT_EQ(solution.components.size(), 1u);
  EXPECT_EQ(solution.components[0].reference, (AnchorId{chain_id("a"), 0}));
  EXPECT_TRUE(solution.changed);
}

TEST(PoseGraph, FourLinksFromTwoPlacesJoin) {
  const GraphSolution solution = two_lines(4).solve();
  ASSERT_EQ(solution.components.size(), 1u);
  EXPECT_LT((pose_of(solution, "b", 19).t - Vector3d(19, 3, 0)).norm(), 1e-4);
  EXPECT_EQ(only_pair(solution).used, 4u);
  EXPECT_EQ(only_pair(solution).places, 2u) << "it need not count more";
}

TEST(PoseGraph, ThreeLinksDoNotAndItSaysSo) {
  const GraphSolution solution = two_lines(3).solve();
  ASSERT_EQ(solution.components.size(), 2u);
  EXPECT_EQ(solution.components[1].chains, std::vector{chain_id("b")});
  EXPECT_EQ(solution.components[1].reason, JoinReason::too_few_links);
  EXPECT_EQ(solution.components[1].number, 3);
  for (const LinkVerdict& verdict : solution.links) EXPECT_EQ(verdict.use, LinkUse::chains_apart);
}

// Two lines; of b only so much. Links between keyframes that hang on two anchors.
PoseGraph one_place(std::size_t length_b, std::uint32_t links) {
  PoseGraph graph = two_lines(0);
  EXPECT_TRUE(graph.set_chain(chain_id("b"), line(length_b)));
  for (std::uint32_t i = 0; i < links; ++i) {
    GraphLink l = link("a", 5, "b", 0, shift(0, 3));
    l.b.keyframe = i;
    EXPECT_TRUE(graph.set_link(l));
  }
  return graph;
}

TEST(PoseGraph, LinksFromOnePlaceJoinWhoWasHardlyElsewhereWhenThereAreMany) {
  EXPECT_EQ(only_pair(one_place(1, 11).solve()).reason, JoinReason::one_place);
  EXPECT_EQ(only_pair(one_place(1, 11).solve()).places, 1u);
  EXPECT_EQ(only_pair(one_place(1, 12).solve()).reason, JoinReason::joined);
  EXPECT_EQ(only_pair(one_place(2, 16).solve()).reason, JoinReason::one_place) << "half of its way is elsewhere";
}

TEST(PoseGraph, WhoWentFurtherMustHaveMetFurtherApart) {
  const auto with = [](std::size_t length, std::uint32_t apart, std::uint32_t links = 4) {
    PoseGraph graph;
    for (const char* name : {"a", "b"}) EXPECT_TRUE(graph.set_chain(chain_id(name), line(length)));
    for (std::uint32_t i = 0; i < links; ++i) {
      GraphLink l = link("a", i % 2 * apart, "b", i % 2 * apart, shift(0, 3));
      l.b.keyframe += i / 2;
      EXPECT_TRUE(graph.set_link(l));
    }
    return only_pair(graph.solve()).reason;
  };
  EXPECT_EQ(with(3, 1), JoinReason::joined) << "two metres of way, a metre apart";
  EXPECT_EQ(with(5, 1), JoinReason::one_place);
  EXPECT_EQ(with(5, 2), JoinReason::joined);
  EXPECT_EQ(with(20, 2), JoinReason::one_place);
  EXPECT_EQ(with(20, 3), JoinReason::joined) << "no door is seen from further";
  EXPECT_EQ(with(20, 2, 12), JoinReason::joined) << "and no more would lie side by side";
}

// Robots that are linked and walk on: nobody looks at them again before the end, and what joined them joins them still.
TEST(PoseGraph, WhatNobodyLookedForSaysNothing) {
  const auto with = [](std::uint32_t known) {
    PoseGraph graph = two_lines(0);
    for (std::uint32_t i = 0; i < 12; ++i) {
      GraphLink l = link("a", i % 4, "b", i % 4, shift(0, 1));
      l.b.keyframe += i / 4;
      l.known_a = l.known_b = known;
      EXPECT_TRUE(graph.set_link(l));
    }
    return only_pair(graph.solve()).reason;
  };
  EXPECT_EQ(with(3), JoinReason::joined);
  EXPECT_EQ(with(kAllKeyframes), JoinReason::unlinked_beside);
}

// Places side by side that no link is between: what is linked there is not what it says.
TEST(PoseGraph, MuchSideBySideWithoutALinkRefutesLinks) {
  const auto with = [](double aside_m) {
    PoseGraph graph = two_lines(0);
    for (std::uint32_t i = 0; i < 4; ++i)
      for (std::uint32_t j = 0; j < 2; ++j) EXPECT_TRUE(graph.set_link(link("a", i, "b", i + j, shift(j, aside_m))));
    return graph.solve();
  };
  const GraphSolution far = with(3), near = with(1);
  EXPECT_EQ(only_pair(far).reason, JoinReason::joined) << "they walk out of each other's sight";
  EXPECT_EQ(only_pair(near).reason, JoinReason::unlinked_beside);
  EXPECT_EQ(near.components.size(), 2u);
}

TEST(PoseGraph, ASecondGroupOfMoreThanHalfIsALookAlike) {
  const auto with = [](std::uint32_t second) {
    PoseGraph graph = two_lines(6);
    for (std::uint32_t i = 0; i < second; ++i)
      EXPECT_TRUE(graph.set_link(link("a", 2 * i, "b", 2 * i + 5, shift(0, 8))));
    return graph.solve();
  };
  EXPECT_EQ(only_pair(with(3)).reason, JoinReason::joined);
  const GraphSolution refused = with(4);
  EXPECT_EQ(only_pair(refused).reason, JoinReason::look_alike);
  EXPECT_EQ(only_pair(refused).number, 4);
  EXPECT_EQ(refused.components.size(), 2u);
}

TEST(PoseGraph, LinksHangOnAnchorsByTheirKeyframes) {
  PoseGraph graph = two_lines(0);
  for (std::uint32_t i = 0; i < 4; ++i) {  // the keyframe is 0.5 m on and turned, so the link is, too
    GraphLink l = link("a", 2 * i, "b", 2 * i, {});
    l.b.T_anchor_keyframe = {test::rotation({0, 0, 1}, 0.4), {0.5, 0, 0}};
    l.T_a_b = shift(0, 3) * l.b.T_anchor_keyframe;
    ASSERT_TRUE(graph.set_link(l));
  }
  EXPECT_LT((pose_of(graph.solve(), "b", 0).t - Vector3d(0, 3, 0)).norm(), 1e-4);
}

TEST(PoseGraph, TheOrderOfInsertionChangesNothing) {
  PoseGraphTeam team(7);
  team.add_right_links(40);
  team.add_random_wrong_links(90);
  const GraphSolution solution = team.graph().solve();
  PoseGraph shuffled;
  test::Random random(1);
  std::vector<GraphLink> links = team.links();
  for (std::size_t i = links.size(); i > 1; --i) std::swap(links[i - 1], links[random.next() % i]);
  for (const GraphLink& l : links) ASSERT_TRUE(shuffled.set_link(l));
  for (int c = 2; c >= 0; --c)
    for (const ChainAnchor& anchor : team.chain(c))
      ASSERT_TRUE(shuffled.set_anchor(PoseGraphTeam::chain_id(c), anchor));
  const GraphSolution other = shuffled.solve();
  ASSERT_EQ(other.anchors.size(), solution.anchors.size());
  for (std::size_t i = 0; i < solution.anchors.size(); ++i)
    EXPECT_EQ(other.anchors[i].T_map_anchor, solution.anchors[i].T_map_anchor);
  for (std::size_t i = 0; i < solution.links.size(); ++i) EXPECT_EQ(other.links[i].number, solution.links[i].number);
}

TEST(PoseGraph, OwnLoopsBendADriftedRing) {
  // Sixty steps round a ring; odometry turns a little too little each time and does not close it.
  constexpr double kTurn = 2 * 3.14159265358979 / 60;
  const auto way = [](double turn, int steps) {
    Pose out;
    for (int i = 0; i < steps; ++i) out = out * Pose{test::rotation({0, 0, 1}, turn), {1, 0, 0}};
    return out;
  };
  PoseGraph graph;
  std::vector<ChainAnchor> anchors = line(60);
  for (std::size_t i = 1; i < 60; ++i) anchors[i].T_previous_anchor = way(kTurn - 0.001, 1);
  ASSERT_TRUE(graph.set_chain(chain_id("a"), anchors));
  const auto error_m = [&](const GraphSolution& solution) {
    return (pose_of(solution, "a", 59).t - way(kTurn, 59).t).norm();
  };
  EXPECT_GT(error_m(graph.solve()), 0.3);
  for (std::uint32_t i = 0; i < 3; ++i) ASSERT_TRUE(graph.set_link(link("a", i, "a", 57 + i, way(kTurn, 57))));
  const GraphSolution solution = graph.solve();
  EXPECT_EQ(only_pair(solution).used, 3u);
  EXPECT_LT(error_m(solution), 0.05);
}

TEST(PoseGraph, AnOwnLoopThatOdometryRulesOutIsRefused) {
  PoseGraph graph;
  ASSERT_TRUE(graph.set_chain(chain_id("a"), line(20)));
  for (std::uint32_t i = 0; i < 6; ++i) ASSERT_TRUE(graph.set_link(link("a", i, "a", 10 + i, shift(2))));
  const GraphSolution solution = graph.solve();
  for (const LinkVerdict& verdict : solution.links) {
    EXPECT_EQ(verdict.use, LinkUse::contradicts_chain);
    EXPECT_GT(verdict.number, 16.81);
  }
  EXPECT_LT((pose_of(solution, "a", 19).t - Vector3d(19, 0, 0)).norm(), 1e-4);
}

// a-b and b-c say eight times each where c is; a-c says so often that it is elsewhere.
GraphSolution three_lines(std::uint32_t against) {
  PoseGraph graph = two_lines(8);
  EXPECT_TRUE(graph.set_chain(chain_id("c"), line(20)));
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_TRUE(graph.set_link(link("b", 2 * i, "c", 2 * i, shift(0, 3))));
  for (std::uint32_t i = 0; i < against; ++i) EXPECT_TRUE(graph.set_link(link("a", 2 * i, "c", 2 * i, shift(0, 20))));
  return graph.solve();
}

TEST(PoseGraph, ThreeChainsWhereAWeakPairIsALookAlike) {
  const GraphSolution solution = three_lines(4);
  ASSERT_EQ(solution.components.size(), 1u);
  EXPECT_LT((pose_of(solution, "c", 0).t - pose_of(solution, "a", 0).t - Vector3d(0, 6, 0)).norm(), 1e-3);
  const auto& pair = solution.pairs[1];
  EXPECT_EQ(pair.b, chain_id("c"));
  EXPECT_EQ(pair.reason, JoinReason::contradicts_others);
  EXPECT_EQ(pair.number, 8);
  EXPECT_EQ(pair.used, 0u);
}

TEST(PoseGraph, ThreeChainsThatContradictEachOtherEquallyStayApart) {
  for (std::uint32_t against : {5u, 8u, 10u}) {
    const GraphSolution solution = three_lines(against);
    EXPECT_EQ(solution.components.size(), 3u) << against;
    for (const PairVerdict& pair : solution.pairs) EXPECT_EQ(pair.reason, JoinReason::contradicts_others);
  }
}

TEST(PoseGraph, ARingOfFourWhoseWeakestPairIsALookAlike) {
  PoseGraph graph = two_lines(8);
  for (const char* name : {"c", "d"}) ASSERT_TRUE(graph.set_chain(chain_id(name), line(20)));
  for (std::uint32_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(graph.set_link(link("b", 2 * i, "c", 2 * i, shift(0, 3))));
    ASSERT_TRUE(graph.set_link(link("c", 2 * i, "d", 2 * i, shift(0, 3))));
  }
  for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(graph.set_link(link("a", 2 * i, "d", 2 * i, shift(0, 30))));
  const GraphSolution solution = graph.solve();
  ASSERT_EQ(solution.components.size(), 1u);
  EXPECT_LT((pose_of(solution, "d", 0).t - pose_of(solution, "a", 0).t - Vector3d(0, 9, 0)).norm(), 1e-3);
  EXPECT_EQ(solution.pairs[1].reason, JoinReason::contradicts_graph);
  EXPECT_EQ(solution.pairs[1].used, 0u);
}

TEST(PoseGraph, ALinkThatIsTakenBackPartsTheMap) {
  PoseGraph graph = two_lines(4);
  const GraphSolution joined = graph.solve();
  graph.remove_link(graph.links().begin()->first);
  const GraphSolution parted = graph.solve(&joined);
  EXPECT_EQ(parted.components.size(), 2u);
  EXPECT_TRUE(parted.changed);
}

TEST(PoseGraph, AUsedLinkThatIsGoneIsAChange) {
  PoseGraph graph = two_lines(5);
  const GraphSolution in_use = graph.solve();
  EXPECT_FALSE(graph.solve(&in_use).changed);
  graph.remove_link(graph.links().begin()->first);
  const GraphSolution next = graph.solve(&in_use);
  EXPECT_EQ(next.components.size(), 1u);
  EXPECT_TRUE(next.changed);
}

TEST(PoseGraph, TheLargestGroupIsTheMapAndItsBestMatchedChainTheReference) {
  PoseGraph graph;
  for (const char* name : {"a", "b", "c", "d"}) ASSERT_TRUE(graph.set_chain(chain_id(name), line(20)));
  for (std::uint32_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(graph.set_link(link("b", 2 * i, "c", 2 * i, shift(0, 3))));
    ASSERT_TRUE(graph.set_link(link("c", 2 * i, "d", 2 * i, shift(0, 3))));
  }
  const GraphSolution solution = graph.solve();
  ASSERT_EQ(solution.components.size(), 2u);
  EXPECT_EQ(solution.components[0].chains.size(), 3u);
  EXPECT_EQ(solution.components[0].reference, (AnchorId{chain_id("c"), 0}));
  EXPECT_EQ(solution.components[1].reason, JoinReason::no_links);
  // More and better links elsewhere do not change it while it is in the map.
  for (std::uint32_t i = 0; i < 9; ++i) {
    GraphLink l = link("b", 2 * i, "d", 2 * i, shift(0, 6));
    l.inliers = 900;
    ASSERT_TRUE(graph.set_link(l));
  }
  EXPECT_EQ(graph.solve().components[0].reference, (AnchorId{chain_id("b"), 0}));
  EXPECT_EQ(graph.solve(&solution).components[0].reference, (AnchorId{chain_id("c"), 0}));
  // When it leaves, the frame stays nevertheless.
  const Pose before = pose_of(solution, "b", 3);
  graph.remove_chain(chain_id("c"));
  const GraphSolution without = graph.solve(&solution);
  EXPECT_LT((pose_of(without, "b", 3).t - before.t).norm(), 1e-9);
}

TEST(PoseGraph, WhatHardlyMovesKeepsItsPoseInUse) {
  PoseGraph graph = two_lines(4);
  const GraphSolution in_use = graph.solve();
  EXPECT_FALSE(graph.solve(&in_use).changed);
  ASSERT_TRUE(graph.set_link(link("a", 9, "b", 9, shift(0, 3.002))));  // bends b by less than 5 mm
  const GraphSolution next = graph.solve(&in_use);
  EXPECT_TRUE(next.changed) << "a link more is in use";
  for (std::size_t i = 0; i < next.anchors.size(); ++i) {
    EXPECT_FALSE(next.anchors[i].moved);
    EXPECT_EQ(next.anchors[i].T_map_anchor, in_use.anchors[i].T_map_anchor);
  }
  GraphSolution off = in_use;  // in use is somewhere else by more than that
  for (SolvedAnchor& anchor : off.anchors)
    if (anchor.id.chain == chain_id("b")) anchor.T_map_anchor.t_10um[1] += 700;
  const GraphSolution moved = graph.solve(&off);
  EXPECT_TRUE(moved.find(AnchorId{chain_id("b"), 4})->moved);
  EXPECT_FALSE(moved.find(AnchorId{chain_id("a"), 4})->moved);
}

TEST(PoseGraph, NewAnchorsHangOnTheLastOnes) {
  PoseGraph graph = two_lines(4);
  const GraphSolution in_use = graph.solve();
  ChainAnchor more = line(2)[1];
  more.keyframe = 20;
  ASSERT_TRUE(graph.set_anchor(chain_id("b"), more));
  const GraphSolution next = graph.solve(&in_use);
  EXPECT_TRUE(next.find(AnchorId{chain_id("b"), 20})->moved);
  EXPECT_LT((pose_of(next, "b", 20).t - Vector3d(20, 3, 0)).norm(), 1e-3);
}

}  // namespace
}  // namespace onemap::mapping
