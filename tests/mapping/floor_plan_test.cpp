#include "mapping/team/floor_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/team/survey.hpp"
#include "support/poses.hpp"
#include "support/true_plan.hpp"

namespace onemap::mapping {
namespace {

using test::Room;
namespace simulated = hal::simulated;

Space space_at(const Survey& survey, const Pose& T_world_map, double x, double y, int around) {
  const FloorPlan& plan = survey.plan;
  const Vector3d p = survey.T_level_map * (T_world_map.inverse() * Vector3d(x, y, 1));
  const int i = static_cast<int>(std::floor((p.x() - plan.origin_x_m) / plan.cell_m));
  const int j = static_cast<int>(std::floor((p.y() - plan.origin_y_m) / plan.cell_m));
  Space best = Space::unknown;
  for (int v = j - around; v <= j + around; ++v)
    for (int u = i - around; u <= i + around; ++u)
      if (u >= 0 && v >= 0 && u < plan.width && v < plan.height) best = std::max(best, plan.at(u, v));
  return best;
}

class FloorPlanOfRoom : public testing::TestWithParam<Room> {};

TEST_P(FloorPlanOfRoom, IsTheRoomsOwn) {
  const Room& room = GetParam();
  const auto keyframes = test::all_keyframes(room, "frames=160&fps=8&seed=4");
  const auto found = survey(keyframes.placed(), {});
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_EQ(found->space.votes_refused, 0u);
  EXPECT_EQ(found->space.keyframes, keyframes.poses.size());
  const Pose T_level_world = found->T_level_map * keyframes.T_world_map.inverse();
  EXPECT_GT(T_level_world.R(2, 2), 0.99863) << "3 degrees";
  EXPECT_NEAR(T_level_world.t.z(), 0, 0.03) << "the floor";
  const double along = std::max(std::abs(T_level_world.R(0, 0)), std::abs(T_level_world.R(0, 1)));
  EXPECT_GT(along, 0.9994) << "2 degrees: walls run along the plan";

  const test::TruePlan truth(simulated::build_scene(room.scene, 4), 0.10, 1.80);
  const test::Score score = score_of(found->plan, T_level_world.inverse(), truth, room);
  RecordProperty("right", std::to_string(score.right()));
  EXPECT_GT(score.right(), 0.95);
  EXPECT_GT(score.free, 1000);
  EXPECT_GT(score.occupied, 300);
  EXPECT_LT(score.outside, (score.free + score.occupied) / 500);
  int walls = 0, missing = 0, through = 0;
  for (double s = -0.45; s < 0.45; s += 0.01)
    for (const auto& [x, y] :
         {std::pair{s * room.size_x, room.size_y / 2}, std::pair{s * room.size_x, -room.size_y / 2},
          std::pair{room.size_x / 2, s * room.size_y}, std::pair{-room.size_x / 2, s * room.size_y}}) {
      ++walls;
      const Space wall = space_at(*found, keyframes.T_world_map, x, y, 1);
      missing += wall == Space::unknown;  // hidden by what stands before it
      through += wall == Space::empty;
    }
  EXPECT_LT(missing, walls / 4);
  EXPECT_LT(through, walls / 50);
}

INSTANTIATE_TEST_SUITE_P(Rooms, FloorPlanOfRoom,
                         testing::Values(Room{"living-room", simulated::SceneName::living_room, 5.6, 4.6, 1},
                                         Room{"office", simulated::SceneName::office, 6.0, 4.8, 2},
                                         Room{"storage", simulated::SceneName::storage, 6.0, 5.0, 1},
                                         Room{"house", simulated::SceneName::house, 10.5, 4.6, 3}),
                         [](const auto& room) {
                           std::string name = room.param.name;
                           std::erase(name, '-');
                           return name;
                         });

// A column of free space, cell by cell: what each cell is, from the lowest.
FloorPlan plan_of_column(const FreeSpaceConfig& config, const std::vector<std::pair<double, Space>>& known) {
  FreeSpace space(config);
  for (const auto& [z, what] : known) {  // a grid of one pixel, a cell above or below it
    DepthGrid grid;
    grid.width = grid.height = 1;
    grid.fx_fy_cx_cy = {1 << 10, 1 << 10, 0, 0};
    grid.inverse_depth = {grid_inverse_depth(what == Space::occupied ? 0.5 : 2.0)};
    // It looks along x at the height of the cell, from half a metre before it or right before it.
    Pose pose;
    pose.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    pose.t = {0.025 - 0.5, 0.025, z};
    for (int i = 0; i < 3; ++i) space.carve(grid, pose);
  }
  const auto plan = floor_plan(space, {});
  return plan ? *plan : FloorPlan{};
}

TEST(FloorPlan, WhatStandsInTheBandIsInTheWayAndNothingElse) {
  const auto at_origin = [](const FloorPlan& plan) {
    if (plan.cells.empty()) return Space::unknown;
    const int x = static_cast<int>(std::lround(-plan.origin_x_m / plan.cell_m));
    const int y = static_cast<int>(std::lround(-plan.origin_y_m / plan.cell_m));
    return x >= 0 && y >= 0 && x < plan.width && y < plan.height ? plan.at(x, y) : Space::unknown;
  };
  const FreeSpaceConfig config;
  EXPECT_EQ(at_origin(plan_of_column(config, {{0.125, Space::occupied}})), Space::occupied);
  EXPECT_EQ(at_origin(plan_of_column(config, {{1.775, Space::occupied}})), Space::occupied);
  EXPECT_EQ(at_origin(plan_of_column(config, {{0.075, Space::occupied}})), Space::unknown) << "a rug";
  EXPECT_EQ(at_origin(plan_of_column(config, {{1.825, Space::occupied}})), Space::unknown) << "a lamp";
  EXPECT_EQ(at_origin(plan_of_column(config, {{0.025, Space::occupied}, {0.425, Space::empty}})), Space::empty)
      << "its floor was seen";
  EXPECT_EQ(at_origin(plan_of_column(config, {{0.425, Space::empty}})), Space::unknown) << "little was seen of it";
}

TEST(FloorPlan, SaysWhatItIsLacking) {
  const auto none = survey({}, {});
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().text().find("no floor"), std::string::npos) << none.error().text();
  const auto nothing = floor_plan(FreeSpace({}), {});
  ASSERT_FALSE(nothing.ok());
  EXPECT_NE(nothing.error().text().find("nothing is known"), std::string::npos) << nothing.error().text();

  FreeSpace far_apart({});
  DepthGrid grid;
  grid.width = grid.height = 1;
  grid.inverse_depth = {grid_inverse_depth(1)};
  for (const double x : {-9e5, 9e5}) far_apart.carve(grid, {Matrix3d::Identity(), {x, x, 0}});
  const auto large = floor_plan(far_apart, {});
  ASSERT_FALSE(large.ok());
  EXPECT_NE(large.error().text().find("larger"), std::string::npos) << large.error().text();
}

TEST(FloorPlan, WhatCannotBeDecodedOrIsTooMuchIsLeftOutAndCounted) {
  auto keyframes = test::simulated_keyframes("simulated:office?frames=60&width=320&height=240", 3);
  SurveyConfig config;
  config.most_keyframes = 7;
  auto found = survey(keyframes.placed(), config);
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_EQ(found->space.keyframes, 7u) << "every third of twenty";
  EXPECT_EQ(found->keyframes_left_out, 13u);
  keyframes.bodies[3].resize(30);
  found = survey(keyframes.placed(), {});
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_EQ(found->keyframes_malformed, 1u);
  EXPECT_EQ(found->space.keyframes, 19u);
}

}  // namespace
}  // namespace onemap::mapping
