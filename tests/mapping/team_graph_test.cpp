#include "mapping/team/team_graph.hpp"

#include <gtest/gtest.h>

#include "mapping/team/placed_anchors.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using test::link_of;
using test::two_metres_each;

struct TeamGraphTest : testing::Test {
  TeamLog log{RobotId::from_name("self"), 1};

  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, Instant{}).ok()); }
  void take(const Author& author) {
    for (const auto& record : author.written()) take(record);
  }
  SolutionRecord solve(const SolutionRecord* in_use = nullptr) const { return solve_team(log, log.chains(), in_use); }
};

std::vector<std::string> names(const SolutionRecord& solution) {
  std::vector<std::string> out;
  for (const SolvedRobot& robot : solution.robots) out.push_back(robot.chain.robot.name());
  return out;
}

TEST_F(TeamGraphTest, LinksPutRobotsIntoOneFrame) {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c"), d = test::small_robot("d");
  LinkRecord aside = link_of("b", "c", 90);  // c began a metre to the left of b
  for (LinkPair& pair : aside.pairs) pair.T_a_b.t_10um[1] = 100'000;
  a.link(link_of("a", "b", 80));
  b.link(aside);
  c.link(link_of("c", "d", 80, LinkReason::ransac_failed));
  for (const Author* author : {&a, &b, &c, &d}) take(*author);
  const SolutionRecord solution = solve();
  EXPECT_EQ(names(solution), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(solution.reference, b.chain()) << "with the most and best matches";
  EXPECT_EQ(solution.links_used, 18u);
  ASSERT_EQ(solution.robots[2].anchors.size(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto& t = solution.robots[2].anchors[i].T_map_anchor.t_10um;
    EXPECT_NEAR(t[0], two_metres_each(i).t_10um[0], 2);
    EXPECT_NEAR(t[1], 100'000, 2);
  }
  EXPECT_EQ(encode(solution), encode(solve())) << "a function of the records";
}

// Sixteen steps of two metres round a square, and odometry turns a little too far in each.
Author drifting_round() {
  Author author("a");
  author.hello();
  const Pose drift = small_motion((Vector6d() << 0, 0.003, 0, 0, 0, 0).finished());
  Pose T;
  for (std::uint32_t i = 0; i < 17; ++i) {
    KeyframeRecord keyframe;
    keyframe.index = keyframe.anchor = i;
    keyframe.T_robot_keyframe = quantize(T);
    author.write(Lane::features, RecordKind::keyframe, keyframe);
    T = T * Pose{Matrix3d::Identity(), {2, 0, 0}};
    if (i % 4 == 3) T = T * Pose{from_quaternion_wxyz({std::sqrt(0.5), 0, std::sqrt(0.5), 0}), Vector3d::Zero()};
    T = T * drift;
  }
  return author;
}

TEST_F(TeamGraphTest, AnOwnLoopBendsTheWayThatLedThere) {
  Author a = drifting_round();
  take(a);
  const SolutionRecord open = solve();
  LinkRecord loops;
  loops.a = loops.b = a.id();
  loops.incarnation_other = 1;
  loops.keyframes_a = loops.keyframes_b = 17;
  loops.pairs = {{0, 16, 300, QuantizedPose{}}, {1, 16, 300, quantize({Matrix3d::Identity(), {-2, 0, 0}})}};
  take(a.link(loops));
  const SolutionRecord closed = solve();
  EXPECT_EQ(closed.links_used, 2u);
  const auto end = [](const SolutionRecord& s) { return from_quantized(s.robots[0].anchors.back().T_map_anchor); };
  EXPECT_GT(end(open).t.norm(), 0.1);
  EXPECT_LT(end(closed).t.norm(), 0.02);
  EXPECT_GT(rotation_cosine(end(closed).R), 0.9999);
  EXPECT_EQ(closed.robots[0].anchors[0], open.robots[0].anchors[0]) << "the frame is the first anchor's";
  EXPECT_FALSE(agree(log, open, closed, 0.05));
}

TEST_F(TeamGraphTest, ASolutionInUseIsKeptWhileItIsRight) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  a.link(link_of("a", "b", 80));
  take(a);
  take(b);
  const SolutionRecord cold = solve();
  SolutionRecord in_use = cold;
  in_use.reference = b.chain();
  for (PlacedAnchor& anchor : in_use.robots[0].anchors) anchor.T_map_anchor.t_10um[2] += 300;  // three millimetres
  const SolutionRecord warm = solve(&in_use);
  EXPECT_EQ(encode(warm), encode(in_use)) << "its reference too, although the other one would be chosen";
  in_use.robots[0].anchors[1].T_map_anchor.t_10um[2] += 2000;
  const SolutionRecord mended = solve(&in_use);
  EXPECT_TRUE(agree(log, mended, warm, 0.012));
  EXPECT_FALSE(agree(log, mended, in_use, 0.012)) << "what the links refute is not kept";
}

TEST_F(TeamGraphTest, NobodyChoosesAnotherFrame) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  a.link(link_of("a", "b", 80));
  take(a);
  take(b);
  const SolutionRecord cold = solve();
  SolutionRecord elsewhere = cold;
  for (SolvedRobot& robot : elsewhere.robots)
    for (PlacedAnchor& anchor : robot.anchors) anchor.T_map_anchor.t_10um[0] += 100'000;
  EXPECT_EQ(encode(solve(&elsewhere)), encode(cold));
  SolutionRecord nobody = cold;
  nobody.reference = {RobotId::from_name("zz"), 1};
  nobody.robots.push_back({nobody.reference, {}});
  EXPECT_EQ(encode(solve(&nobody)), encode(cold));
}

TEST_F(TeamGraphTest, RobotsWithoutKeyframesAreNoMapButTheFirst) {
  EXPECT_TRUE(solve().robots.empty());
  Author b("b"), a("a");
  b.hello();
  a.hello();
  take(b);
  take(a);
  const SolutionRecord solution = solve();
  EXPECT_EQ(solution.reference, a.chain());
  EXPECT_EQ(names(solution), (std::vector<std::string>{"a"}));
}

// Half a metre each, and each its own anchor.
Author walker(const std::string& name, std::uint32_t keyframes) {
  Author out(name);
  out.hello();
  for (std::uint32_t i = 0; i < keyframes; ++i) {
    KeyframeRecord keyframe;
    keyframe.index = keyframe.anchor = i;
    keyframe.T_robot_keyframe.t_10um[0] = static_cast<std::int32_t>(50'000 * i);
    out.write(Lane::features, RecordKind::keyframe, keyframe);
  }
  return out;
}

// Linked once, they walk on side by side: that there are no later links parts no map.
TEST_F(TeamGraphTest, RobotsThatWalkOnAfterTheyWereLinkedStayTogether) {
  Author a = walker("a", 40);
  const Author b = walker("b", 40);
  LinkRecord link = link_of("a", "b", 80);
  link.keyframes_a = link.keyframes_b = 4;
  link.pairs.clear();
  for (std::uint32_t i = 0; i < 4; ++i)
    for (std::uint32_t j = 0; j < 4; ++j) {
      LinkPair& pair = link.pairs.emplace_back(LinkPair{i, j, 80, {}});
      pair.T_a_b.t_10um[0] = 50'000 * (static_cast<std::int32_t>(j) - static_cast<std::int32_t>(i));
    }
  a.link(link);
  take(a);
  take(b);
  EXPECT_EQ(names(solve()), (std::vector<std::string>{"a", "b"}));
  link.keyframes_a = link.keyframes_b = 40;
  take(a.link(link));
  EXPECT_EQ(solve().robots.size(), 1u) << "all was looked at, and much would lie side by side without a link";
}

// What was known when it was verified is counted in records of the log, and some of these only say where an earlier
// keyframe was that is seen no more.
TEST_F(TeamGraphTest, WhatALinkKnewIsCountedInRecordsAndNotInKeyframes) {
  Author a = walker("a", 6);
  for (const std::uint32_t gone : {1u, 2u, 3u}) {
    KeyframeRecord place;
    place.index = place.anchor = gone;
    place.T_robot_keyframe.t_10um[0] = static_cast<std::int32_t>(50'000 * gone);
    a.replacing(gone).write(Lane::features, RecordKind::keyframe, place);
  }
  KeyframeRecord later;
  later.index = later.anchor = 6;
  a.write(Lane::features, RecordKind::keyframe, later);
  LinkRecord link = link_of("a", "b", 80);
  link.keyframes_a = 9;  // six, and three places: the seventh keyframe came later
  link.keyframes_b = 3;
  a.link(link);
  take(a);
  take(test::small_robot("b"));
  const PoseGraph graph = team_graph(log, log.chains());
  ASSERT_FALSE(graph.links().empty());
  for (const auto& [id, pair] : graph.links()) EXPECT_EQ(pair.known_a, 5u);
}

// What links claim of keyframes that nobody has, or that hang on no anchor, changes nothing.
TEST_F(TeamGraphTest, LinksOfUnknownKeyframesAreLeftOut) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  for (const std::uint32_t index : {3u, 4u}) {  // 3 hangs on 2, and 4 on 3, which is no anchor
    KeyframeRecord astray;
    astray.index = index;
    astray.anchor = index - 1;
    b.write(Lane::features, RecordKind::keyframe, astray);
  }
  LinkRecord link = link_of("a", "b", 80);
  link.pairs.push_back({2, 4, 900, {}});
  link.pairs.push_back({77, 0, 900, {}});
  a.link(link);
  take(a);
  take(b);
  EXPECT_EQ(team_graph(log, log.chains()).links().size(), 9u);
  EXPECT_EQ(solve().robots.size(), 2u);
}

TEST_F(TeamGraphTest, AnchorsThatTheSolutionDoesNotHaveHangOnTheOneBefore) {
  Author a = test::small_robot("a");
  take(a);
  SolutionRecord solution = solve();
  SolvedRobot& solved = solution.robots[0];
  const SolvedRobot all = solved;
  solved.anchors = {{1, all.anchors[1].T_map_anchor}};
  solved.anchors[0].T_map_anchor.t_10um[1] = 500;
  const auto placed = placed_anchors(*log.find(a.id()), solved);
  ASSERT_EQ(placed.size(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(placed[i].keyframe, i);
    EXPECT_EQ(placed[i].T_map_anchor.t_10um, (std::array<std::int32_t, 3>{two_metres_each(i).t_10um[0], 500, 0}));
  }
  take(a.keyframe());
  EXPECT_EQ(placed_anchors(*log.find(a.id()), solved).size(), 4u) << "new ones too";
  solved.chain.incarnation = 2;
  EXPECT_TRUE(placed_anchors(*log.find(a.id()), solved).empty()) << "of another life";
}

// A robot that came round, and was in places between where nothing of it is needed any more.
class BareAnchors : public TeamGraphTest {
 protected:
  Author a_ = drifting_round();

  void SetUp() override {
    LinkRecord loops;
    loops.a = loops.b = a_.id();
    loops.incarnation_other = 1;
    loops.keyframes_a = loops.keyframes_b = 17;
    loops.pairs = {{0, 16, 300, QuantizedPose{}}, {1, 16, 300, quantize({Matrix3d::Identity(), {-2, 0, 0}})}};
    a_.link(loops);
    take(a_);
  }
  RecordPtr place_alone_of(std::uint32_t keyframe) {
    KeyframeRecord place;
    const KeyframePlace& known = log.find(a_.id())->keyframes.places()[keyframe];
    place.index = known.index;
    place.anchor = known.anchor;
    place.T_robot_keyframe = known.T_robot_keyframe;
    return a_.replacing(keyframe).write(Lane::features, RecordKind::keyframe, place);
  }
  std::vector<std::uint32_t> solved() const {
    const SolutionRecord solution = solve();
    std::vector<std::uint32_t> out;
    for (const PlacedAnchor& anchor : solution.robots.at(0).anchors) out.push_back(anchor.keyframe);
    return out;
  }
};

TEST_F(BareAnchors, AreLeftOutAndTheWayIsBentAllTheSame) {
  const TeamMember& member = *log.find(a_.id());
  const auto before = placed_anchors(member, solve().robots.at(0));
  const double open_by = from_quantized(member.keyframes.places()[16].T_robot_keyframe).t.norm();
  const std::uint64_t revision = log.revision();
  for (std::uint32_t i = 2; i < 15; ++i) take(place_alone_of(i));
  EXPECT_GT(log.revision(), revision);
  EXPECT_EQ(solved(), (std::vector<std::uint32_t>{0, 1, 15, 16}));
  const auto after = placed_anchors(member, solve().robots.at(0));
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    const double off = (from_quantized(after[i].T_map_anchor).t - from_quantized(before[i].T_map_anchor).t).norm();
    EXPECT_LT(off, i < 2 || i > 14 ? 0.01 : 0.07) << i << ": a loop of 32 m that was open by " << open_by;
  }
  SolutionRecord all = solve();
  all.robots[0].anchors = before;
  EXPECT_TRUE(agree(log, all, solve(), 0.05));
}

TEST_F(BareAnchors, WhatSomethingHangsOnStays) {
  take(a_.submap({}, 9, 3));
  KeyframeRecord hanging;
  hanging.index = 17;
  hanging.anchor = 5;
  take(a_.write(Lane::features, RecordKind::keyframe, hanging));
  for (std::uint32_t i = 0; i < 16; ++i) take(place_alone_of(i));
  EXPECT_EQ(solved(), (std::vector<std::uint32_t>{0, 1, 3, 5, 16})) << "the first, a link's, voxels', a keyframe's";
  const std::uint64_t revision = log.revision();
  take(a_.replacing(0).submap({}, 9, 16));
  EXPECT_GT(log.revision(), revision);
  EXPECT_EQ(solved(), (std::vector<std::uint32_t>{0, 1, 5, 16})) << "others' voxels took their place";
}

TEST_F(BareAnchors, AreTheSameToWhomTheirBodiesNeverReached) {
  take(a_.submap({}, 9, 3));
  for (std::uint32_t i = 2; i < 15; ++i) take(place_alone_of(i));
  take(a_.replacing(0).submap({}, 9, 16));
  TeamLog late{RobotId::from_name("late"), 1};
  for (const RecordPtr& record : a_.written()) {
    const bool old_keyframe =
        record->id.log.lane == static_cast<std::uint8_t>(Lane::features) && record->id.seq >= 2 && record->id.seq < 15;
    const bool old_voxels = record->id.log.lane == static_cast<std::uint8_t>(Lane::voxels) && record->id.seq == 0;
    ASSERT_TRUE(late.apply(old_keyframe || old_voxels ? test::without_body(record) : record, Instant{}).ok());
  }
  EXPECT_EQ(encode(solve_team(late, late.chains())), encode(solve()));
}

TEST_F(TeamGraphTest, BetweenTwoAnchorsOfTheSolutionTheWayIsBentEvenly) {
  Author a = test::small_robot("a");
  a.keyframe();
  a.keyframe();
  take(a);
  SolvedRobot solved{a.chain(), {{0, two_metres_each(0)}, {4, two_metres_each(4)}}};
  solved.anchors[1].T_map_anchor.t_10um[1] = 4000;
  solved.anchors[1].T_map_anchor.q_wxyz = quantize({from_quaternion_wxyz({1, 0, 0, 0.1}), {}}).q_wxyz;
  const auto placed = placed_anchors(*log.find(a.id()), solved);
  ASSERT_EQ(placed.size(), 5u);
  const auto angle = [&](std::size_t i) { return placed[i].T_map_anchor.q_wxyz[3] / double{1 << 30}; };
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(angle(i), 0.025 * static_cast<double>(i), 0.001) << i;
  EXPECT_EQ(between({}, {from_quaternion_wxyz({0, 0, 0, 1}), {1, 0, 0}}, 0.4).t.x(), 0) << "no way is the shorter one";
  EXPECT_EQ(between({}, {from_quaternion_wxyz({0, 0, 0, 1}), {1, 0, 0}}, 0.6).t.x(), 1);
}

}  // namespace
}  // namespace onemap::mapping
