// Two robots in a corridor ring whose doors look alike, over many seeds: what is linked and merged, and what of it is
// right by the simulation's truth. In the first scene they never see the same place, so any merge is wrong; in the
// second the one walks into what the other one saw.
//   bench_ring_soak [SEEDS] [FIRST] [apart|meeting]    default: 50 seeds from 1 of both scenes, some 10 s of one core
// each. Ends with 1 when anything was merged wrongly.
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "mapping/team/team_graph.hpp"
#include "mapping/team/verify.hpp"
#include "support/explorer.hpp"
#include "support/poses.hpp"
#include "support/team_author.hpp"

using namespace onemap;
using namespace onemap::mapping;

namespace {

constexpr double kWrong_m = 0.2, kWrong_rad = 0.0873;  // five degrees

struct Scene {
  const char* name;
  int robots, frames;  // of the ring; ten frames a second, 0.6 m a second
};

struct Tally {
  int seeds = 0, refused = 0, right = 0, wrong = 0, merged = 0, merged_wrong = 0, pairs = 0, pairs_wrong = 0;
};

// How far a relation of two poses is from the true one.
struct Off {
  double m = 0, rad = 0;
  bool is_wrong() const { return m > kWrong_m || rad > kWrong_rad; }
};

Off off_of(const Pose& should, const Pose& is) {
  const Pose off = should.inverse() * is;
  return {.m = off.t.norm(), .rad = test::rotation_angle(off.R)};
}

test::Author author_of(const char* name, const test::Explorer& robot) {
  test::Author out(name);
  out.hello();
  for (const KeyframeRecord& keyframe : robot.keyframes) out.write(Lane::features, RecordKind::keyframe, keyframe);
  return out;
}

// What the team makes of the link.
SolutionRecord merge(const test::Explorer& a, const test::Explorer& b, const LinkRecord& link) {
  TeamLog log(RobotId::from_name("self"), 1);
  test::Author of_a = author_of("a", a);
  of_a.link(link);
  for (const test::Author& author : {of_a, author_of("b", b)})
    for (const RecordPtr& record : author.written()) static_cast<void>(log.apply(record, Instant{}));
  return solve_team(log, log.chains());
}

std::size_t place_of(const test::Explorer& robot, std::uint32_t index) {
  return static_cast<std::size_t>(std::ranges::find(robot.keyframes, index, &KeyframeRecord::index) -
                                  robot.keyframes.begin());
}

Pose true_relation(const test::Explorer& a, const test::Explorer& b, const LinkPair& pair) {
  return a.T_world_keyframe.at(place_of(a, pair.keyframe_a)).inverse() *
         b.T_world_keyframe.at(place_of(b, pair.keyframe_b));
}

// Where the solution lays a keyframe, by its anchor.
Pose laid(const SolvedRobot& robot, const test::Explorer& of, std::uint32_t index) {
  const auto pose_of = [&](std::uint32_t keyframe) {
    return from_quantized(of.keyframes.at(place_of(of, keyframe)).T_robot_keyframe);
  };
  const auto after = std::ranges::upper_bound(robot.anchors, index, {}, &PlacedAnchor::keyframe);
  const PlacedAnchor& anchor = after == robot.anchors.begin() ? *after : *std::prev(after);
  return from_quantized(anchor.T_map_anchor) * pose_of(anchor.keyframe).inverse() * pose_of(index);
}

// A link, or a merge, is right when it is at the places that it joins; what the robots drifted on their ways from their
// first poses to there is no mistake of it, and printed beside.
void run(const Scene& scene, int seed, Tally& tally) {
  const std::string ring =
      fmt::format("simulated:ring?robots={}&frames={}&fps=10&seed={}&robot=", scene.robots, scene.frames, seed);
  const test::Explorer a = test::explore(ring + "1"), b = test::explore(ring + "2");
  LinkRecord link =
      verify_robots(RobotId::from_name("a"), a.keyframes, RobotId::from_name("b"), b.keyframes, VerifyConfig{});
  link.incarnation_other = 1;
  const bool accepted = link.reason == LinkReason::accepted;
  const SolutionRecord solution = merge(a, b, link);
  const bool merged = solution.robots.size() == 2;
  int wrong = 0, merged_wrong = 0;
  double most_m = 0, most_merged_m = 0;
  for (const LinkPair& pair : link.pairs) {
    const Pose should = true_relation(a, b, pair);
    const Off linked = off_of(should, from_quantized(pair.T_a_b));
    wrong += linked.is_wrong();
    most_m = std::max(most_m, linked.m);
    if (!merged) continue;
    const Off is = off_of(
        should, laid(solution.robots[0], a, pair.keyframe_a).inverse() * laid(solution.robots[1], b, pair.keyframe_b));
    merged_wrong += is.is_wrong();
    most_merged_m = std::max(most_merged_m, is.m);
  }
  // Some of a link's pairs may not agree with it; the pose graph refuses them. Those that do must be right.
  const bool link_is_wrong = wrong > static_cast<int>(link.pairs.size()) - static_cast<int>(link.supporting_pairs);
  ++tally.seeds;
  tally.refused += !accepted;
  (link_is_wrong ? tally.wrong : tally.right) += accepted;
  tally.merged += merged;
  tally.merged_wrong += merged && (merged_wrong > 0 || link.pairs.empty());
  tally.pairs += static_cast<int>(link.pairs.size());
  tally.pairs_wrong += wrong;
  fmt::print("{} seed {:3}: {} and {} keyframes, {}, {} pairs agree{}{}{}\n", scene.name, seed, a.keyframes.size(),
             b.keyframes.size(), accepted ? "linked" : fmt::format("refused ({})", static_cast<int>(link.reason)),
             link.supporting_pairs,
             accepted ? fmt::format(", a pair at most {:.2f} m off{}, {:.2f} m at the robots' first poses", most_m,
                                    link_is_wrong ? ": WRONG" : "",
                                    off_of(a.T_world_first.inverse() * b.T_world_first, from_quantized(link.T_a_b)).m)
                      : "",
             merged ? fmt::format(", merged, at most {:.2f} m off", most_merged_m) : "",
             merged_wrong > 0 ? ": MERGED WRONGLY" : "");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 50, first = argc > 2 ? std::atoi(argv[2]) : 1;
  int wrong = 0;
  for (const Scene& scene : {Scene{"apart", 2, 150}, Scene{"meeting", 6, 200}}) {
    if (argc > 3 && std::string(argv[3]) != scene.name) continue;
    Tally tally;
    for (int seed = first; seed < first + seeds; ++seed) run(scene, seed, tally);
    fmt::print(
        "== {}: {} seeds, {} refused, {} linked rightly, {} linked wrongly, {} merged, {} merged wrongly; of {} pairs "
        "in links {} are wrong\n",
        scene.name, tally.seeds, tally.refused, tally.right, tally.wrong, tally.merged, tally.merged_wrong, tally.pairs,
        tally.pairs_wrong);
    wrong += tally.wrong + tally.merged_wrong;
  }
  return wrong > 0;
}
