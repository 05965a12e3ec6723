#include "mapping/team/reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace onemap::mapping {
namespace {

RobotId id(const char* name) { return RobotId::from_name(name); }

LinkRecord link(const char* a, const char* b, std::uint32_t inliers, const Vector3d& t,
                LinkReason reason = LinkReason::accepted) {
  LinkRecord l;
  l.a = id(a);
  l.b = id(b);
  l.reason = reason;
  l.inliers = inliers;
  l.ratio_e4 = 2000;
  l.T_a_b = quantize({Matrix3d::Identity(), t});
  return l;
}

Pose placed(const SolutionRecord& s, const char* name) {
  for (const SolvedRobot& r : s.robots)
    if (r.robot == id(name)) return from_quantized(r.T_global_robot);
  ADD_FAILURE() << name << " is not in the solution";
  return {};
}

TEST(Solve, ReferenceHasTheMostAndBestMatches) {
  const std::vector<RobotId> robots{id("a"), id("b"), id("c")};
  const std::vector<LinkRecord> links{link("a", "b", 100, {1, 0, 0}), link("b", "c", 300, {0, 2, 0})};
  const SolutionRecord s = solve(robots, links);
  EXPECT_EQ(s.reference, id("b"));
  EXPECT_EQ(s.robots.size(), 3u);
  EXPECT_LT((placed(s, "c").t - Vector3d(0, 2, 0)).norm(), 1e-4);
  EXPECT_LT((placed(s, "a").t - Vector3d(-1, 0, 0)).norm(), 1e-4);
}

// Eq. (12): through two links.
TEST(Solve, TransformsPropagateAlongTheLinks) {
  const std::vector<RobotId> robots{id("a"), id("b"), id("c"), id("d")};
  std::vector<LinkRecord> links{link("a", "b", 500, {1, 0, 0}), link("b", "c", 100, {0, 2, 0}),
                                link("c", "d", 90, {0, 0, 3}), link("a", "c", 10, {9, 9, 9})};
  const SolutionRecord s = solve(robots, links);
  EXPECT_LT(((placed(s, "a").inverse() * placed(s, "d")).t - Vector3d(1, 2, 3)).norm(), 1e-4)
      << "the weak link must not be used";
  EXPECT_EQ(s.links_used, 3u);
  std::reverse(links.begin(), links.end());
  const SolutionRecord t = solve(robots, links);
  EXPECT_EQ(encode(s), encode(t)) << "the order of the links must not matter";
}

TEST(Solve, RobotWithoutMatchesStaysOut) {
  const std::vector<RobotId> robots{id("a"), id("b"), id("c")};
  const std::vector<LinkRecord> links{link("a", "b", 100, {1, 0, 0}),
                                      link("a", "c", 400, {5, 0, 0}, LinkReason::ransac_failed)};
  const SolutionRecord s = solve(robots, links);
  EXPECT_EQ(s.robots.size(), 2u);
  EXPECT_FALSE(std::any_of(s.robots.begin(), s.robots.end(), [](const SolvedRobot& r) { return r.robot == id("c"); }));
}

// Two robots that praise each other do not take the map from three.
TEST(Solve, TheLargestGroupIsTheMap) {
  const std::vector<RobotId> robots{id("-x"), id("-y"), id("a"), id("b"), id("c")};
  const std::vector<LinkRecord> links{link("-x", "-y", 32000, {1, 0, 0}), link("a", "b", 100, {1, 0, 0}),
                                      link("b", "c", 90, {0, 1, 0})};
  const SolutionRecord s = solve(robots, links);
  EXPECT_EQ(s.reference, id("b"));
  EXPECT_EQ(s.robots.size(), 3u);
}

TEST(Solve, RobotsBeyondWhatAPoseCanSayAreAsFarAsItCan) {
  const std::vector<RobotId> robots{id("a"), id("b"), id("c")};
  const std::vector<LinkRecord> links{link("a", "b", 100, {20000, 0, 0}), link("b", "c", 200, {-20000, 20000, 0})};
  const SolutionRecord s = solve(robots, links);
  EXPECT_EQ(s.reference, id("b"));
  const std::vector<LinkRecord> chain{link("a", "b", 300, {20000, 0, 0}), link("b", "c", 200, {20000, 0, 0}),
                                      link("a", "d", 1000, {0, 0, 0})};
  const std::vector<RobotId> four{id("a"), id("b"), id("c"), id("d")};
  const SolutionRecord far = solve(four, chain);
  EXPECT_EQ(far.reference, id("a"));
  EXPECT_EQ(far.robots[2].T_global_robot.t_10um[0], 2147483647);
}

TEST(Solve, OneRobotAloneIsItsOwnReference) {
  const std::vector<RobotId> robots{id("x")};
  const SolutionRecord s = solve(robots, {});
  EXPECT_EQ(s.reference, id("x"));
  EXPECT_EQ(s.robots.size(), 1u);
}

}  // namespace
}  // namespace onemap::mapping
