// The pose graph's steps, each alone.
#include <gtest/gtest.h>

#include <numeric>

#include "pose_graph_team.hpp"
#include "team/pose_graph/chain_frame.hpp"
#include "team/pose_graph/clique.hpp"
#include "team/pose_graph/gnc.hpp"
#include "team/pose_graph/keep.hpp"
#include "team/pose_graph/pair_links.hpp"
#include "team/pose_graph/se3.hpp"

namespace onemap::mapping {
namespace {

Vector6d small(test::Random& random, double size) {
  Vector6d d;
  for (int i = 0; i < 6; ++i) d[i] = random.uniform(-size, size);
  return d;
}

TEST(PoseGraphSe3, AdjointMovesASmallMotionThroughAPose) {
  test::Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose X = test::random_pose(random, 3, 5);
    const Vector6d d = small(random, 1e-5);
    const Vector6d other = motion_error(X * small_motion(d) * X.inverse());
    EXPECT_LT((other - adjoint(X) * d).norm(), 1e-8);
  }
}

TEST(PoseGraphSe3, SlopesAreThoseOfDifferences) {
  test::Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Pose X_a = test::random_pose(random, 3, 5), X_b = test::random_pose(random, 3, 5);
    const GraphEdge edge{0, 1, X_a.inverse() * X_b * test::random_pose(random, 1, 1), Matrix6d::Identity()};
    const Linearised at = linearise(edge, X_a, X_b);
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = 1e-6 * Vector6d::Unit(k);
      const Vector6d by_a = linearise(edge, X_a * small_motion(d), X_b).error - at.error;
      const Vector6d by_b = linearise(edge, X_a, X_b * small_motion(d)).error - at.error;
      EXPECT_LT((by_a / 1e-6 - at.J_a.col(k)).norm(), 1e-4);
      EXPECT_LT((by_b / 1e-6 - at.J_b.col(k)).norm(), 1e-4);
    }
  }
}

// The largest clique by trying all subsets.
std::size_t clique_number(const AgreementGraph& graph) {
  std::size_t best = 0;
  for (std::uint32_t set = 0; set < 1u << graph.size(); ++set) {
    bool all = true;
    for (std::size_t i = 0; i < graph.size() && all; ++i)
      for (std::size_t j = i + 1; j < graph.size() && all; ++j)
        if ((set >> i & 1) && (set >> j & 1)) all = graph.agree(i, j);
    if (all) best = std::max<std::size_t>(best, static_cast<std::size_t>(std::popcount(set)));
  }
  return best;
}

TEST(PoseGraphClique, IsTheLargest) {
  test::Random random(3);
  for (int round = 0; round < 40; ++round) {
    AgreementGraph graph(14);
    for (std::size_t i = 0; i < 14; ++i)
      for (std::size_t j = i + 1; j < 14; ++j)
        if (random.uniform(0, 1) < 0.4 + 0.01 * round) graph.set(i, j);
    std::vector<std::size_t> all(14);
    std::iota(all.begin(), all.end(), std::size_t{0});
    const auto clique = largest_clique(graph, all, 100'000);
    EXPECT_EQ(clique.size(), clique_number(graph));
    for (std::size_t i : clique)
      for (std::size_t j : clique) EXPECT_TRUE(i == j || graph.agree(i, j));
  }
}

TEST(PoseGraphClique, FindsAPlantedGroupAmongManyAndWithoutAnySteps) {
  test::Random random(4);
  AgreementGraph graph(300);
  for (std::size_t i = 0; i < 300; ++i)
    for (std::size_t j = i + 1; j < 300; ++j)
      if (random.uniform(0, 1) < 0.05 || (i % 20 == 0 && j % 20 == 0)) graph.set(i, j);
  std::vector<std::size_t> all(300);
  std::iota(all.begin(), all.end(), std::size_t{0});
  EXPECT_EQ(largest_clique(graph, all, 100'000).size(), 15u);
  EXPECT_EQ(largest_clique(graph, all, 0).size(), 15u) << "the heuristic finds it";
  EXPECT_TRUE(largest_clique(graph, {}, 1).empty());
}

TEST(PoseGraphGnc, WeightsGoFromNearlyConvexToTruncated) {
  EXPECT_EQ(gnc_weight(1, 16, 1), 1);
  EXPECT_EQ(gnc_weight(32, 16, 1), 0);
  EXPECT_NEAR(gnc_weight(16, 16, 1), std::sqrt(2.0) - 1, 1e-12);
  EXPECT_EQ(gnc_weight(15.9, 16, 1e6), 1);
  EXPECT_EQ(gnc_weight(16.1, 16, 1e6), 0);
  EXPECT_GT(gnc_weight(1000, 16, 0.01), 0);
}

TEST(PoseGraphKeep, TheFarthestCornerDecides) {
  ChainAnchor anchor;
  anchor.box_half_m = {1, 1, 1};
  const Pose turned{test::rotation({0, 0, 1}, 0.003), Vector3d::Zero()};
  EXPECT_FALSE(box_moved(anchor, {}, turned, 0.005)) << "4.2 mm at the corners";
  anchor.box_centre_m = {1, 0, 0};
  EXPECT_TRUE(box_moved(anchor, {}, turned, 0.005)) << "6.7 mm at the far corners";
  EXPECT_FALSE(box_moved(anchor, {}, {Matrix3d::Identity(), {0.0049, 0, 0}}, 0.005));
  EXPECT_TRUE(box_moved(anchor, {}, {Matrix3d::Identity(), {0.005, 0, 0}}, 0.005));
}

// Links across a long way with drift: right ones agree, because the covariance grows with the way and its lever arms.
TEST(PoseGraphAgreement, RightLinksAgreeHoweverFarApart) {
  int agree = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    test::PoseGraphTeam team(seed, {.chains = 2, .anchors = 200, .drift_m = 0.01, .drift_rad = 0.01, .step_m = 0.5});
    team.add_right_links(12);
    const PoseGraph graph = team.graph();
    const GraphIndex index = index_of(graph, {});
    std::vector<const GraphEdge*> edges;
    for (const IndexedLink& link : index.links) edges.push_back(&link.edge);
    const AgreementGraph agreement = agreement_of(chain_frames(index), edges, false, 16.81);
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) ++all, agree += agreement.agree(i, j);
  }
  EXPECT_GT(agree, all * 98 / 100) << "of " << all
                                   << "; 99 % by the bound, less what is not linear in a radian of drift";
  EXPECT_LT(agree, all) << "the bound is not so wide that nothing fails";
}

// Own loops whose ways overlap share the drift of the steps in both; also when a later keyframe hangs on an earlier
// anchor.
TEST(PoseGraphAgreement, StepsInBothLoopsCancelOrCountTwice) {
  PoseGraph graph;
  std::vector<ChainAnchor> anchors(40);
  for (std::uint32_t i = 0; i < 40; ++i) {
    anchors[i].keyframe = i;
    anchors[i].information = information_of(1e-4, 0.05);
  }
  const ChainId id{RobotId::from_name("a"), 1};
  ASSERT_TRUE(graph.set_chain(id, anchors));
  const GraphIndex index = index_of(graph, {});
  const ChainFrames frames = chain_frames(index);
  const auto agrees = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d, double apart_m) {
    const Matrix6d sure = information_of(1e-4, 1e-3);
    const Pose off{Matrix3d::Identity(), {apart_m, 0, 0}};
    const GraphEdge p{a, b, {}, sure}, q{c, d, off, sure};
    const std::vector<const GraphEdge*> both{&p, &q};
    return agreement_of(frames, both, true, 16.81).agree(0, 1);
  };
  // Sigma 5 cm times the root of the steps in one of them alone; four sigmas are within the bound, 4.2 are not.
  EXPECT_TRUE(agrees(0, 20, 4, 20, 0.40)) << "4 steps differ";
  EXPECT_FALSE(agrees(0, 20, 4, 20, 0.42));
  EXPECT_TRUE(agrees(0, 20, 18, 22, 0.05 * 4 * std::sqrt(20)));
  EXPECT_FALSE(agrees(0, 20, 18, 22, 0.05 * 4.2 * std::sqrt(20))) << "2 steps are in both and cancel";
  EXPECT_TRUE(agrees(0, 20, 22, 18, 0.05 * 4 * std::sqrt(28))) << "backwards they count twice";
  EXPECT_FALSE(agrees(0, 20, 22, 18, 0.05 * 4.2 * std::sqrt(28)));
}

}  // namespace
}  // namespace onemap::mapping
