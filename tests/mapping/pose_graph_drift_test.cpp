// A robot that walks round and round, and whose odometry drifts to one side as real ones do: over the whole way it is
// off by far more than random steps would be.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "mapping/team/pose_graph.hpp"
#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

constexpr std::uint32_t kRound = 40, kRounds = 40, kAnchors = kRound * kRounds;

class DriftingWay : public ::testing::Test {
 protected:
  DriftingWay() {
    Pose step = truth(0).inverse() * truth(1);
    step.t *= 1.005;
    step.R = step.R * test::rotation({0, 0, 1}, 0.003);  // 5 rad over the whole way, for which 0.4 are claimed
    for (std::uint32_t i = 0; i < kAnchors; ++i) {
      ChainAnchor& anchor = chain.emplace_back();
      anchor.keyframe = i;
      anchor.information = information_of(0.01, 0.014);
      anchor.T_previous_anchor = i == 0 ? truth(0) : step * noise(0.002, 0.004);
    }
  }
  static Pose truth(std::uint32_t anchor) {
    const double turned = 2 * std::numbers::pi * (anchor % kRound) / kRound;
    return {test::rotation({0, 0, 1}, turned), {2 * std::cos(turned), 2 * std::sin(turned), 1}};
  }
  Pose noise(double rad, double m) { return test::random_pose(random, rad, m); }
  GraphLink loop(std::uint32_t earlier, std::uint32_t later, const Pose& T_earlier_later) const {
    return {{id, earlier, earlier, {}}, {id, later, later, {}}, T_earlier_later};
  }
  // From each fifth anchor of the later rounds to what was seen there in the first one.
  void add_right(std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t later = from; later < to; later += 5) {
      const std::uint32_t earlier = (later + 1) % kRound;
      loops.push_back(loop(earlier, later, truth(earlier).inverse() * truth(later) * noise(0.005, 0.01)));
      right.insert(loops.back().id());
    }
  }
  // So many from there on say that it is a metre and a half higher, which by odometry alone it might be by then.
  void add_look_alikes(std::uint32_t from, std::uint32_t count) {
    for (std::uint32_t later = from; later < from + count; ++later) {
      const std::uint32_t there = (later + 1) % kRound;
      const Pose higher{Matrix3d::Identity(), {0, 0, 1.5}};
      loops.push_back(loop(there, later, truth(there).inverse() * higher * truth(later) * noise(0.005, 0.01)));
    }
  }
  PoseGraph graph(std::uint32_t anchors = kAnchors) const {
    PoseGraph out;
    EXPECT_TRUE(out.set_chain(id, {chain.begin(), chain.begin() + anchors}));
    for (const GraphLink& link : loops)
      if (link.b.keyframe < anchors) {
        EXPECT_TRUE(out.set_link(link));
      }
    return out;
  }
  static double worst_m(const GraphSolution& solution) {
    double worst = 0;
    for (const SolvedAnchor& anchor : solution.anchors)
      worst = std::max(worst, (from_quantized(anchor.T_map_anchor).t - truth(anchor.id.keyframe).t).norm());
    return worst;
  }
  void expect_right_alone_used(const GraphSolution& solution) const {
    std::size_t right_used = 0, wrong_used = 0;
    for (const LinkVerdict& link : solution.links)
      if (link.use == LinkUse::used) (right.contains(link.id) ? right_used : wrong_used) += 1;
    EXPECT_GE(right_used, solution.links.size() - (loops.size() - right.size()) - right.size() / 50);
    EXPECT_EQ(wrong_used, 0u);
  }

  const ChainId id{RobotId::from_name("a"), 1};
  test::Random random{7};
  std::vector<ChainAnchor> chain;
  std::vector<GraphLink> loops;
  std::set<LinkId> right;
};

TEST_F(DriftingWay, OdometryAloneIsMetresOff) { EXPECT_GT(worst_m(graph().solve()), 3); }

TEST_F(DriftingWay, WhatComesBackIsHeldHoweverLongAgoItBegan) {
  add_right(kRound, kAnchors);
  const GraphSolution solution = graph().solve();
  expect_right_alone_used(solution);
  EXPECT_TRUE(solution.effort.converged);
  EXPECT_LT(worst_m(solution), 0.05);
}

// As a robot that works solves it: each time with some more, from what it had.
TEST_F(DriftingWay, AndWhileItGrows) {
  add_right(kRound, kAnchors);
  GraphSolution solution = graph(2 * kRound).solve();
  for (std::uint32_t anchors = 4 * kRound; anchors <= kAnchors; anchors += 4 * kRound) {
    solution = graph(anchors).solve(&solution);
    EXPECT_LT(worst_m(solution), 0.05) << anchors;
  }
  expect_right_alone_used(solution);
}

TEST_F(DriftingWay, APlaceThatLooksLikeAnotherIsNoneHoweverOftenItIsSeen) {
  add_right(kRound, 20 * kRound);
  add_look_alikes(20 * kRound + 5, 60);
  add_right(22 * kRound + 5, kAnchors);
  const GraphSolution solution = graph().solve();
  expect_right_alone_used(solution);
  EXPECT_EQ(solution.pairs.at(0).agree, right.size());
  EXPECT_LT(worst_m(solution), 0.06) << "sixty steps without a loop";
}

// Of loops that exclude each other the more count, also when the fewer come first.
TEST_F(DriftingWay, WhoWasWrongFirstDoesNotOutvoteTheOthers) {
  for (std::uint32_t later = kRound; later < kRound + 3; ++later)  // near enough for odometry
    loops.push_back(loop(later - kRound, later, Pose{Matrix3d::Identity(), {0, 0.5, 0}} * noise(0.001, 0.001)));
  add_right(kRound + 4, kAnchors);
  const GraphSolution solution = graph().solve();
  EXPECT_GE(solution.pairs.at(0).agree, right.size() - 10);
  expect_right_alone_used(solution);
  EXPECT_LT(worst_m(solution), 0.05);
}

// Another robot on the same way, whose odometry drifts to the other side: over what both have walked by now their links
// would contradict each other.
TEST_F(DriftingWay, LinksOfTwoSuchRobotsAgreeAllAlong) {
  add_right(kRound, kAnchors);
  PoseGraph both = graph();
  const ChainId other{RobotId::from_name("b"), 1};
  std::vector<ChainAnchor> way = chain;
  for (std::uint32_t i = 1; i < kAnchors; ++i) {
    const Pose step = truth(i - 1).inverse() * truth(i);
    way[i].T_previous_anchor = step * (step.inverse() * chain[i].T_previous_anchor).inverse();
  }
  ASSERT_TRUE(both.set_chain(other, way));
  for (const GraphLink& own : loops) {
    GraphLink theirs = own;
    theirs.a.chain = theirs.b.chain = other;
    ASSERT_TRUE(both.set_link(theirs));
  }
  constexpr std::uint32_t kEach = 20;
  for (std::uint32_t i = 0; i < kAnchors; i += kEach)
    ASSERT_TRUE(both.set_link({{id, i, i, {}}, {other, i, i, {}}, noise(0.005, 0.01)}));
  const GraphSolution solution = both.solve();
  ASSERT_EQ(solution.pairs.size(), 3u);
  EXPECT_GE(solution.pairs[1].agree, kAnchors / kEach * 95 / 100);
}

}  // namespace
}  // namespace onemap::mapping
