// What a whole team makes of records when most of the pairs in its links are wrong: three robots of 60 keyframes that
// drift, as hello, keyframes and links.
#include <gtest/gtest.h>

#include "mapping/team/team_graph.hpp"
#include "pose_graph_team.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using test::PoseGraphTeam;

constexpr int kRobots = 3;
constexpr std::uint64_t kSeeds = 20;

Author author_of(const PoseGraphTeam& team, int robot) {
  Author out(PoseGraphTeam::chain_id(robot).robot.name());
  out.hello();
  Pose T_robot_keyframe;
  for (const ChainAnchor& anchor : team.chain(robot)) {
    T_robot_keyframe = T_robot_keyframe * anchor.T_previous_anchor;
    KeyframeRecord keyframe;
    keyframe.index = keyframe.anchor = anchor.keyframe;
    keyframe.T_robot_keyframe = quantize(T_robot_keyframe);
    out.write(Lane::features, RecordKind::keyframe, keyframe);
  }
  return out;
}

// The links of the team between each two robots, as the record that the first of them writes.
void write_links(const PoseGraphTeam& team, bool right_only, std::vector<Author>& authors) {
  std::map<std::pair<RobotId, RobotId>, LinkRecord> links;
  for (const GraphLink& link : team.links())
    if (!right_only || team.right().contains(link.id()))
      links[{link.a.chain.robot, link.b.chain.robot}].pairs.push_back(
          {link.a.keyframe, link.b.keyframe, link.inliers, quantize(link.T_a_b)});
  for (auto& [robots, link] : links) {
    std::tie(link.a, link.b) = robots;
    link.incarnation_other = 1;
    link.keyframes_a = link.keyframes_b = 60;
    link.inliers = link.supporting_pairs = static_cast<std::uint32_t>(link.pairs.size());
    const auto ends = [](const LinkPair& pair) { return std::pair(pair.keyframe_a, pair.keyframe_b); };
    std::ranges::sort(link.pairs, {}, ends);
    std::ranges::find(authors, link.a, &Author::id)->link(link);
  }
}

TeamLog log_of(const PoseGraphTeam& team, bool right_only = false) {
  std::vector<Author> authors;
  for (int robot = 0; robot < kRobots; ++robot) authors.push_back(author_of(team, robot));
  write_links(team, right_only, authors);
  TeamLog log(RobotId::from_name("self"), 1);
  for (const Author& author : authors)
    for (const RecordPtr& record : author.written()) EXPECT_TRUE(log.apply(record, Instant{}).ok());
  return log;
}

// The anchors of a Solution, so that they can be compared with truth.
GraphSolution anchors_of(const SolutionRecord& solution) {
  GraphSolution out;
  for (const SolvedRobot& robot : solution.robots)
    for (const PlacedAnchor& anchor : robot.anchors)
      out.anchors.push_back({.id = {robot.chain, anchor.keyframe}, .T_map_anchor = anchor.T_map_anchor});
  return out;
}

struct Outcome {
  int right = 0, kept = 0, wrong_kept = 0, whole = 0;
};

Outcome run(int wrong) {
  Outcome out;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PoseGraphTeam team(3000 + seed);
    team.add_right_links(24);
    team.add_random_wrong_links(wrong);
    const TeamLog log = log_of(team), clean_log = log_of(team, true);
    const GraphSolution verdicts = team_graph(log, log.chains()).solve();
    EXPECT_EQ(verdicts.links.size(), team.links().size()) << "the records hold every pair";
    out.right += team.used(team_graph(clean_log, clean_log.chains()).solve(), true);
    out.kept += team.used(verdicts, true);
    out.wrong_kept += team.used(verdicts, false);
    const SolutionRecord solution = solve_team(log, log.chains()), clean = solve_team(clean_log, clean_log.chains());
    EXPECT_EQ(team.misplaced_chains(verdicts), 0) << "seed " << seed;
    if (solution.robots.size() != clean.robots.size()) continue;
    ++out.whole;
    EXPECT_LT(team.ate_m(anchors_of(solution)), 1.5 * team.ate_m(anchors_of(clean))) << "seed " << seed;
  }
  return out;
}

void expect_kept(const Outcome& out) {
  EXPECT_GT(out.right, 300) << "or there is nothing to keep";
  EXPECT_GE(out.kept, out.right * 9 / 10);
  EXPECT_EQ(out.wrong_kept, 0);
  EXPECT_GE(out.whole, static_cast<int>(kSeeds) * 9 / 10) << "teams with the same robots as without wrong pairs";
}

TEST(TeamOutliers, SeventyPercentWrongPairs) { expect_kept(run(56)); }

TEST(TeamOutliers, NinetyFivePercentWrongPairs) { expect_kept(run(456)); }

TEST(TeamOutliers, WhereAllIsWrongNobodyIsMerged) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    PoseGraphTeam team(4000 + seed);
    team.add_random_wrong_links(480);
    team.add_doubles(12, 3, 0, 1);  // and a door like another one
    const TeamLog log = log_of(team);
    const SolutionRecord solution = solve_team(log, log.chains());
    EXPECT_EQ(solution.robots.size(), 1u) << "seed " << seed;
    EXPECT_EQ(solution.links_used, 0u);
    EXPECT_EQ(solution.links_refused, team.links().size());
  }
}

}  // namespace
}  // namespace onemap::mapping
