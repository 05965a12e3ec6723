// Two robots in a corridor ring whose doors look alike, over many seeds: what is linked and merged, and what of it is
// right by the simulation's truth. In the first scene they never see the same place, so any merge is wrong; in the
// second the one walks into what the other one saw.
//   bench_ring_soak [SEEDS] [FIRST] [apart|meeting]    default: 50 seeds from 1 of both scenes, some 10 s of one core
// each. Ends with 1 when anything was merged wrongly.
#include <fmt/core.h>

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

constexpr double kWrong_m = 0.5, kWrong_rad = 0.1745;  // ten degrees

struct Scene {
  const char* name;
  int robots, frames;  // of the ring; ten frames a second, 0.6 m a second
};

struct Tally {
  int seeds = 0, refused = 0, right = 0, wrong = 0, merged = 0, merged_wrong = 0, pairs = 0, pairs_wrong = 0;
};

bool is_wrong(const Pose& should, const Pose& is) {
  const Pose off = should.inverse() * is;
  return off.t.norm() > kWrong_m || test::rotation_angle(off.R) > kWrong_rad;
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

void count_pairs(const test::Explorer& a, const test::Explorer& b, const LinkRecord& link, const Pose& truth,
                 Tally& tally) {
  const auto pose_of = [](const test::Explorer& robot, std::uint32_t index) {
    for (const KeyframeRecord& keyframe : robot.keyframes)
      if (keyframe.index == index) return from_quantized(keyframe.T_robot_keyframe);
    return Pose{};
  };
  for (const LinkPair& pair : link.pairs) {
    ++tally.pairs;
    const Pose T_a_b = pose_of(a, pair.keyframe_a) * from_quantized(pair.T_a_b) * pose_of(b, pair.keyframe_b).inverse();
    tally.pairs_wrong += is_wrong(truth, T_a_b);
  }
}

void run(const Scene& scene, int seed, Tally& tally) {
  const std::string ring =
      fmt::format("simulated:ring?robots={}&frames={}&fps=10&seed={}&robot=", scene.robots, scene.frames, seed);
  const test::Explorer a = test::explore(ring + "1"), b = test::explore(ring + "2");
  LinkRecord link =
      verify_robots(RobotId::from_name("a"), a.keyframes, RobotId::from_name("b"), b.keyframes, VerifyConfig{});
  link.incarnation_other = 1;
  const Pose truth = a.T_world_first.inverse() * b.T_world_first;
  const bool accepted = link.reason == LinkReason::accepted;
  const bool wrong = accepted && is_wrong(truth, from_quantized(link.T_a_b));
  const SolutionRecord solution = merge(a, b, link);
  bool merged = solution.robots.size() == 2, merged_wrong = false;
  if (merged) {
    const auto first = [&](std::size_t robot) {
      return from_quantized(solution.robots[robot].anchors.front().T_map_anchor);
    };
    merged_wrong = is_wrong(truth, first(0).inverse() * first(1));
  }
  ++tally.seeds;
  tally.refused += !accepted;
  (wrong ? tally.wrong : tally.right) += accepted;
  tally.merged += merged;
  tally.merged_wrong += merged_wrong;
  count_pairs(a, b, link, truth, tally);
  const Pose off = truth.inverse() * from_quantized(link.T_a_b);
  fmt::print("{} seed {:3}: {} and {} keyframes, {}, {} pairs agree{}{}\n", scene.name, seed, a.keyframes.size(),
             b.keyframes.size(), accepted ? "linked" : fmt::format("refused ({})", static_cast<int>(link.reason)),
             link.supporting_pairs,
             accepted ? fmt::format(", {:.2f} m off{}", off.t.norm(), wrong ? ": WRONG" : "") : "",
             merged_wrong ? ", MERGED WRONGLY"
             : merged     ? ", merged"
                          : "");
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
