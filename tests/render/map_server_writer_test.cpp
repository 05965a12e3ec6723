#include "render/map_server_writer.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#ifdef ONEMAP_HAVE_OPENCV_IMGCODECS
#include <opencv2/imgcodecs.hpp>
#endif

#include "hal/base/file.hpp"
#include "support/other_program.hpp"
#include "support/true_plan.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

using mapping::FloorPlan;
using mapping::Space;

FloorPlan small_plan() {
  FloorPlan plan;
  plan.width = 3, plan.height = 2;
  plan.cell_m = 0.05;
  plan.origin_x_m = -1.25, plan.origin_y_m = 0.5;
  plan.cells = {Space::unknown, Space::empty, Space::occupied, Space::empty, Space::empty, Space::unknown};
  return plan;
}

TEST(MapServer, the_files_are_the_documented_ones) {
  const test::TempFolder folder;
  const mapping::Pose T{mapping::Matrix3d::Identity(), {0, 0, 1.5}};
  ASSERT_TRUE(write_map_server(folder / "map", small_plan(), T).ok());
  EXPECT_EQ(*read_text_file(folder / "map.pgm"),
            std::string("P5\n# onemap, 0.050 m a pixel\n3 2\n255\n") + "\xfe\xfe\xcd\xcd\xfe" + std::string(1, '\0'))
      << "largest y first";
  EXPECT_EQ(*read_text_file(folder / "map.yaml"),
            "# onemap: z is up, the floor is z = 0. A point of the map's frame is T_plan_map * point;\n"
            "# T_plan_map (tx ty tz qx qy qz qw): 0.000000 0.000000 1.500000 0.000000000 0.000000000 0.000000000 "
            "1.000000000\n"
            "image: map.pgm\nresolution: 0.050000\norigin: [-1.250000, 0.500000, 0.0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST(MapServer, a_folder_that_is_not_there_is_said) {
  const auto written = write_map_server("/nonexistent/map", small_plan(), {});
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().text().find("/nonexistent/map.pgm"), std::string::npos) << written.error().text();
}

#ifdef ONEMAP_HAVE_OPENCV_IMGCODECS
// What nav2_map_server makes of a pixel with negate 0 in trinary mode, by the thresholds of the yaml.
Space as_map_server_reads(int value, double occupied_thresh, double free_thresh) {
  const double occupancy = (255 - value) / 255.0;
  if (occupancy >= occupied_thresh) return Space::occupied;
  return occupancy <= free_thresh ? Space::empty : Space::unknown;
}

// Reads both files as somebody else does; nothing where the readers are missing or the files are wrong.
std::optional<FloorPlan> read_back(const std::string& folder, const std::string& python) {
  const test::Said yaml =
      test::say("cd '" + folder + "' && " + python +
                " -c 'import yaml; m = yaml.safe_load(open(\"map.yaml\")); print(m[\"image\"], m[\"resolution\"], "
                "*m[\"origin\"], m[\"negate\"], m[\"occupied_thresh\"], m[\"free_thresh\"])'");
  char image[64] = "";
  double resolution = 0, x = 0, y = 0, yaw = 0, occupied = 0, free = 0;
  int negate = -1;
  if (std::sscanf(yaml.output.c_str(), "%63s %lf %lf %lf %lf %d %lf %lf", image, &resolution, &x, &y, &yaw, &negate,
                  &occupied, &free) != 8 ||
      negate != 0 || yaw != 0)
    return std::nullopt;
  const cv::Mat pixels = cv::imread(folder + "/" + image, cv::IMREAD_UNCHANGED);
  if (pixels.empty() || pixels.type() != CV_8UC1) return std::nullopt;
  FloorPlan plan;
  plan.width = pixels.cols, plan.height = pixels.rows;
  plan.cell_m = resolution;
  plan.origin_x_m = x, plan.origin_y_m = y;
  for (int row = pixels.rows - 1; row >= 0; --row)
    for (int column = 0; column < pixels.cols; ++column)
      plan.cells.push_back(as_map_server_reads(pixels.at<std::uint8_t>(row, column), occupied, free));
  return plan;
}

mapping::Pose pose_in_comment(const std::string& file) {
  const std::string text = *read_text_file(file), before = "(tx ty tz qx qy qz qw): ";
  double v[7] = {};
  std::sscanf(text.c_str() + text.find(before) + before.size(), "%lf %lf %lf %lf %lf %lf %lf", &v[0], &v[1], &v[2],
              &v[3], &v[4], &v[5], &v[6]);
  return {mapping::from_quaternion_wxyz({v[6], v[3], v[4], v[5]}), {v[0], v[1], v[2]}};
}

TEST(MapServer, a_room_is_read_by_others_as_it_is) {
  const std::string python = test::python_with("yaml");
  if (python.empty()) GTEST_SKIP() << "python3-yaml is not installed";
  const test::TempFolder folder;
  const test::Room room{"office", hal::simulated::SceneName::office, 6.0, 4.8, 2};
  const auto keyframes = test::all_keyframes(room, "frames=160&fps=8&seed=7");
  const auto survey = mapping::survey(keyframes.placed(), {});
  ASSERT_TRUE(survey.ok()) << survey.error().text();
  ASSERT_TRUE(write_map_server(folder / "map", survey->plan, survey->T_level_map).ok());

  const auto plan = read_back(folder / "", python);
  ASSERT_TRUE(plan.has_value());
  EXPECT_EQ(plan->cells, survey->plan.cells);
  const mapping::Pose T_world_plan = keyframes.T_world_map * pose_in_comment(folder / "map.yaml").inverse();
  EXPECT_GT(T_world_plan.R(2, 2), 0.99863) << "upright within 3 degrees";
  const test::TruePlan truth(hal::simulated::build_scene(room.scene, 7), 0.10, 1.80);
  const test::Score score = score_of(*plan, T_world_plan, truth, room);
  EXPECT_GT(score.right(), 0.95);
  EXPECT_GT(score.free, 1000);
  EXPECT_GT(score.occupied, 1000);
  EXPECT_LT(score.outside, 10);
}
#else
TEST(MapServer, a_room_is_read_by_others_as_it_is) { GTEST_SKIP() << "OpenCV's imgcodecs is not installed"; }
#endif

}  // namespace
}  // namespace onemap::render
