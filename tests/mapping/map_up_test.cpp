#include "mapping/team/map_up.hpp"

#include <gtest/gtest.h>

#include "support/simulated_keyframes.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

// A robot whose keyframes are those of a simulated room.
struct MapUpTest : testing::Test {
  test::Author author{"a"};
  test::SimulatedKeyframes room = test::simulated_keyframes("simulated:living-room?frames=60&seed=3", 6);
  TeamLog log{author.id(), 1};
  SolutionRecord solution = alone_on_map(author.chain());
  Vector3f truth = (room.T_world_map.R.transpose() * Vector3d::UnitZ()).cast<float>();
  void SetUp() override { take(author.hello()); }
  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, {})); }
  void add_keyframes(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      take(author.write(Lane::features, static_cast<std::uint16_t>(RecordKind::keyframe), room.bodies[i]));
  }
  double off_deg(const UpDirection& up) const {
    return std::acos(std::min(1.0f, unit_vector(up).dot(truth))) * 57.29577951308232;
  }
};

TEST_F(MapUpTest, IsThatOfTheRoom) {
  add_keyframes(0, room.bodies.size());
  MapUp up;
  EXPECT_LT(off_deg(up.final(log, solution)), 1.0);
  EXPECT_GT(off_deg({}), 3.0) << "the camera is not level itself";
  EXPECT_EQ(up.final(log, solution), MapUp().now(log, solution, nullptr));
}

TEST_F(MapUpTest, IsThatOfTheMapsFrame) {
  add_keyframes(0, room.bodies.size());
  const Pose turned{from_quaternion_wxyz({0.9238795, 0, 0, 0.3826834}), {1, 2, 3}};
  solution.robots[0].anchors.push_back({0, quantize(turned)});
  const Vector3f up = unit_vector(MapUp().final(log, solution));
  EXPECT_LT((up - turned.R.cast<float>() * truth).norm(), 0.02f);
}

TEST_F(MapUpTest, StaysWhileTheMapIsAboutTheSame) {
  add_keyframes(0, 6);
  MapUp up;
  SolutionRecord in_use = solution;
  in_use.up = up.now(log, solution, nullptr);
  const UpDirection marked{{0, 0, 1'000'000}};
  in_use.up = marked;
  add_keyframes(6, 8);
  EXPECT_EQ(up.now(log, solution, &in_use), marked);
  add_keyframes(8, 10);
  EXPECT_NE(up.now(log, solution, &in_use), marked) << "half as many keyframes more";
  in_use.reference.incarnation = 7;
  EXPECT_NE(up.now(log, solution, &in_use), marked) << "another frame";
}

TEST_F(MapUpTest, WithoutKeyframesItIsALevelCamerasUp) {
  EXPECT_EQ(MapUp().final(log, solution), UpDirection{});
  EXPECT_EQ(up_direction(unit_vector({})), UpDirection{});
}

}  // namespace
}  // namespace onemap::mapping
