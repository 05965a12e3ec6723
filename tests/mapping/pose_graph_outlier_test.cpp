// Simulated teams: three chains of 60 anchors that drift by 4 mm and 3 mrad a step, 40 right links and 20 own loops,
// and wrong ones of both.
#include <gtest/gtest.h>

#include "pose_graph_team.hpp"

namespace onemap::mapping {
namespace {

using test::PoseGraphTeam;

constexpr int kSeeds = 50;

struct Outcome {
  int right = 0, right_kept = 0, wrong_kept = 0, misplaced = 0, in_map = 0;
};

// Solves with and without the wrong links; the error may be half as much again where both have the same chains.
template <class AddWrong>
Outcome run(const AddWrong& add_wrong) {
  Outcome out;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PoseGraphTeam team(1000 + seed);
    team.add_right_links(40);
    team.add_right_loops(20);
    add_wrong(team);
    const GraphSolution solution = team.graph().solve(), clean = team.graph(true).solve();
    out.right += team.used(clean, true);
    out.right_kept += team.used(solution, true);
    out.wrong_kept += team.used(solution, false);
    out.misplaced += team.misplaced_chains(solution);
    out.in_map += static_cast<int>(solution.components[0].chains.size());
    EXPECT_TRUE(solution.effort.converged);
    if (solution.components[0].chains == clean.components[0].chains) {
      EXPECT_LT(team.ate_m(solution), 1.5 * team.ate_m(clean)) << "seed " << seed;
    }
    // Starting from its own answer changes nothing.
    EXPECT_FALSE(team.graph().solve(&solution).changed) << "seed " << seed;
  }
  return out;
}

void report(const Outcome& out) {
  ::testing::Test::RecordProperty("right_kept", out.right_kept);
  ::testing::Test::RecordProperty("wrong_kept", out.wrong_kept);
  ::testing::Test::RecordProperty("chains_in_map", out.in_map);
}

TEST(PoseGraphOutliers, SeventyPercentRandom) {
  const Outcome out = run([](PoseGraphTeam& team) {
    team.add_random_wrong_links(93);
    team.add_random_wrong_loops(47);
  });
  report(out);
  EXPECT_GE(out.right_kept, out.right * 98 / 100);
  EXPECT_EQ(out.wrong_kept, 0);
  EXPECT_EQ(out.misplaced, 0);
}

TEST(PoseGraphOutliers, NinetyFivePercentRandom) {
  const Outcome out = run([](PoseGraphTeam& team) {
    team.add_random_wrong_links(760);
    team.add_random_wrong_loops(380);
  });
  report(out);
  EXPECT_GE(out.right_kept, out.right * 98 / 100);
  EXPECT_LE(out.wrong_kept, 1) << "one that agrees by chance within its sigmas bends nothing";
  EXPECT_EQ(out.misplaced, 0);
}

// Six links each that agree with each other on a wrong place, all from one place or all along the way.
TEST(PoseGraphOutliers, SeventyPercentInLookAlikeGroups) {
  for (bool one_place : {true, false}) {
    const Outcome out = run([&](PoseGraphTeam& team) {
      for (int i = 0; i < 15; ++i) team.add_look_alikes(6, one_place);
    });
    // Where a group is more than half of what is right between two chains, these are not joined by it; with two such
    // pairs a chain stays out, and its right links with it.
    EXPECT_GE(out.right_kept, out.right * 85 / 100) << one_place;
    EXPECT_EQ(out.wrong_kept, 0) << one_place;
    EXPECT_EQ(out.misplaced, 0) << one_place;
  }
}

// A group as large as the right links between its two chains: it may part the map, but not bend it.
TEST(PoseGraphOutliers, ALookAlikeAsLargeAsWhatIsRightPartsTheMap) {
  const Outcome out = run([](PoseGraphTeam& team) { team.add_look_alikes(13, false, 0, 1); });
  EXPECT_EQ(out.wrong_kept, 0);
  EXPECT_EQ(out.misplaced, 0);
}

// Chains that only wrong links join stay apart.
TEST(PoseGraphOutliers, WrongLinksAloneJoinNobody) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PoseGraphTeam team(seed);
    team.add_random_wrong_links(760);
    EXPECT_EQ(team.graph().solve().components.size(), 3u) << "seed " << seed;
  }
}

// Doors that look alike, six links each, from one place: nobody is joined by them.
TEST(PoseGraphOutliers, LookAlikesOfOnePlaceJoinNobody) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PoseGraphTeam team(seed);
    for (int i = 0; i < 3; ++i) team.add_look_alikes(6, true);
    EXPECT_EQ(team.graph().solve().components.size(), 3u) << "seed " << seed;
  }
}

// A place that is like another one, and nothing contradicts it: links between all that is near, a metre and a half of
// each way. Right ones between the same chains join.
TEST(PoseGraphOutliers, APlaceThatIsLikeAnotherOneJoinsNobodyHoweverManyLinksItGives) {
  int right = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (int links : {6, 20}) {
      PoseGraphTeam team(2000 + seed, {.chains = 2});
      team.add_doubles(links, 3, 0, 1);
      EXPECT_EQ(team.graph().solve().components.size(), 2u) << "seed " << seed << ", " << links;
    }
    PoseGraphTeam team(2000 + seed, {.chains = 2});
    team.add_right_links(13);
    right += team.graph().solve().components.size() == 1;
  }
  EXPECT_GE(right, kSeeds * 85 / 100);
}

// Three metres of each way.
TEST(PoseGraphOutliers, SoDoesALargerOne) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    for (int links : {6, 20}) {
      PoseGraphTeam team(2000 + seed, {.chains = 2});
      team.add_doubles(links, 6, 0, 1);
      EXPECT_EQ(team.graph().solve().components.size(), 2u) << "seed " << seed << ", " << links;
    }
}

}  // namespace
}  // namespace onemap::mapping
