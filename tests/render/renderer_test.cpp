#include "render/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "picture.hpp"
#include "render/legend.hpp"
#include "render/png_writer.hpp"
#include "room_scene.hpp"
#include "simulated_room.hpp"

namespace onemap::render {
namespace {

using mapping::Vector3f;
using test::add_box;

class Drawing : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = open_egl_renderer();
    if (!opened) GTEST_SKIP() << "no EGL driver that draws without a display: " << opened.error().text();
    renderer_ = std::move(*opened);
    style_.width_px = 320;
    style_.height_px = 240;
    style_.shading = 0;
    style_.depth_cues = 0;
  }
  Image draw(const Scene& scene, const Camera& camera) {
    auto image = renderer_->draw(scene, camera, style_);
    EXPECT_TRUE(image.ok()) << image.error().text();
    return image.ok() ? *image : Image();
  }
  std::size_t count(const Image& image, Color color) const {
    std::size_t n = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) n += image.at(x, y) == color ? 1 : 0;
    return n;
  }
  static Camera camera_at(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up = {0, -1, 0}) {
    Camera camera;
    camera.eye = eye;
    camera.target = target;
    camera.up = up;
    return camera;
  }
  std::unique_ptr<Renderer> renderer_;
  Style style_;
};

constexpr Color kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255}, kYellow{255, 255, 0}, kCyan{0, 255, 255},
    kMagenta{255, 0, 255};

TEST_F(Drawing, a_cube_shows_each_face_to_the_camera_before_it) {
  Scene scene;
  add_box(scene.mesh, {-1, -1, 4}, {1, 1, 6}, false, 1, {{kRed, kGreen, kBlue, kYellow, kCyan, kMagenta}});
  for (auto& c : scene.mesh.colors)  // add_box darkens nothing with one tile a face
    ASSERT_TRUE(c == kRed || c == kGreen || c == kBlue || c == kYellow || c == kCyan || c == kMagenta);
  const struct {
    glm::vec3 from, up;
    Color color;
  } cases[] = {{{0, 5, 0}, {0, 0, 1}, kRed},     {{0, -5, 0}, {0, 0, 1}, kGreen}, {{-5, 0, 0}, {0, -1, 0}, kBlue},
               {{5, 0, 0}, {0, -1, 0}, kYellow}, {{0, 0, -5}, {0, -1, 0}, kCyan}, {{0, 0, 5}, {0, -1, 0}, kMagenta}};
  const glm::vec3 center{0, 0, 5};
  for (const auto& c : cases) {
    const Image image = draw(scene, camera_at(center + c.from, center, c.up));
    EXPECT_EQ(image.at(160, 120), c.color);
    EXPECT_EQ(image.at(3, 3), style_.background);
  }
}

// A pinhole camera maps a triangle at depth z to f/z times its size: both place and area are known.
TEST_F(Drawing, a_triangle_covers_the_pixels_that_the_pinhole_model_says) {
  Scene scene;
  scene.mesh.vertices = {{-1, 1, 4}, {1, 1, 4}, {-1, -1, 4}};  // y down: right angle at the lower left
  scene.mesh.colors = {kRed, kRed, kRed};
  scene.mesh.triangles = {{0, 2, 1}};
  style_.both_sides = true;
  const Camera camera = camera_at({0, 0, 0}, {0, 0, 1});
  const Image image = draw(scene, camera);
  const double f_px = 120 / std::tan(camera.fov_y_rad / 2), scale = f_px / 4;
  EXPECT_NEAR(static_cast<double>(count(image, kRed)), 2 * scale * scale, 8 * scale * 0.5);  // up to half the rim
  const auto at = [&](double x, double y) {
    return image.at(static_cast<int>(160 + x * scale), static_cast<int>(120 + y * scale));
  };
  EXPECT_EQ(at(-0.95, 0.95), kRed);
  EXPECT_EQ(at(0.85, 0.95), kRed);
  EXPECT_EQ(at(-0.95, -0.85), kRed);
  EXPECT_EQ(at(0.5, -0.5), style_.background);
  EXPECT_EQ(at(-1.05, 0.5), style_.background);
  EXPECT_EQ(at(0.0, 1.05), style_.background);
}

TEST_F(Drawing, surfaces_from_behind_are_seen_through_unless_asked_for) {
  Scene scene;
  test::add_tiles(scene.mesh, {-5, -5, 3}, {10, 0, 0}, {0, 10, 0}, 1, kRed, kRed);  // looks along +z: away
  const Camera camera = camera_at({0, 0, 0}, {0, 0, 1});
  EXPECT_EQ(draw(scene, camera).at(160, 120), style_.background);
  style_.both_sides = true;
  EXPECT_EQ(draw(scene, camera).at(160, 120), kRed);
}

TEST_F(Drawing, the_nearer_point_hides_the_farther_and_is_larger) {
  Scene scene;
  scene.points.points = {{0, 0, 4}, {0, 0, 2}, {0.8f, 0, 4}};
  scene.points.colors = {kBlue, kRed, kGreen};
  style_.point_size_m = 0.2f;
  const Camera camera = camera_at({0, 0, 0}, {0, 0, 1});
  const Image image = draw(scene, camera);
  const double f_px = 120 / std::tan(camera.fov_y_rad / 2);
  EXPECT_EQ(count(image, kBlue), 0u);
  EXPECT_NEAR(std::sqrt(static_cast<double>(count(image, kRed))), 0.2 * f_px / 2, 1.5);
  EXPECT_NEAR(std::sqrt(static_cast<double>(count(image, kGreen))), 0.2 * f_px / 4, 1.5);
  EXPECT_EQ(image.at(static_cast<int>(160 + 0.8 * f_px / 4), 120), kGreen);
}

TEST_F(Drawing, a_dense_cloud_is_closed_without_a_given_point_size) {
  Scene scene;
  for (int y = -100; y <= 100; ++y)
    for (int x = -100; x <= 100; ++x) {
      scene.points.points.emplace_back(0.02f * static_cast<float>(x), 0.02f * static_cast<float>(y), 2.0f);
      scene.points.colors.push_back(kGreen);
    }
  const Image image = draw(scene, camera_at({0, 0, 0}, {0, 0, 1}));
  EXPECT_EQ(count(image, kGreen), 320u * 240u);
}

TEST_F(Drawing, a_trajectory_is_a_band_of_the_given_width_in_the_robots_colour) {
  Scene scene;
  RobotPath path{"robot1", kRed, {}, {}};
  for (int i = 0; i <= 20; ++i) path.poses.push_back(test::level_pose(-1 + 0.1 * i, 0, 3, 0));
  scene.robots = {path};
  style_.path_width_px = 6;
  const Image image = draw(scene, camera_at({0, 0, 0}, {0, 0, 1}));
  for (const int x : {100, 160, 220}) {
    int rows = 0;
    for (int y = 0; y < image.height; ++y) rows += image.at(x, y) == kRed ? 1 : 0;
    EXPECT_NEAR(rows, 6, 1) << "column " << x;
  }
  EXPECT_EQ(image.at(5, 120), style_.background);
}

TEST_F(Drawing, a_path_behind_a_wall_shines_through_faintly) {
  Scene scene;
  test::add_tiles(scene.mesh, {-5, -5, 2}, {0, 10, 0}, {10, 0, 0}, 1, {255, 255, 255}, {255, 255, 255});
  RobotPath path{"robot1", {200, 0, 0}, {}, {}};
  for (int i = 0; i <= 20; ++i) path.poses.push_back(test::level_pose(-1 + 0.1 * i, 0, 3, 0));
  scene.robots = {path};
  style_.path_width_px = 6;
  const Color faint = draw(scene, camera_at({0, 0, 0}, {0, 0, 1})).at(160, 120);
  EXPECT_GT(faint[0], 225);
  EXPECT_LT(faint[0], 250);
  EXPECT_GT(faint[1], 150);
  EXPECT_LT(faint[1], 220);
}

TEST_F(Drawing, a_path_through_the_camera_does_not_smear_over_the_picture) {
  Scene scene;
  scene.robots = {{"robot1", kRed, {test::level_pose(0, 0.2, -5, 0), test::level_pose(0, 0.2, 5, 0)}, {}}};
  const Image image = draw(scene, camera_at({0, 0, 0}, {0, 0, 1}));
  const std::size_t painted = count(image, kRed);
  EXPECT_GT(painted, 50u);
  EXPECT_LT(painted, 1500u);
  EXPECT_EQ(image.at(160, 60), style_.background);  // the way is below the axis (y down): only the lower half
}

TEST_F(Drawing, a_way_has_a_ring_at_its_start_and_a_dot_at_its_end) {
  Scene scene;
  scene.robots = {{"robot1", kRed, {test::level_pose(-1, 0, 3, 0), test::level_pose(1, 0, 3, 0)}, {}}};
  style_.path_width_px = 6;
  const Image image = draw(scene, camera_at({0, 0, 0}, {0, 0, 1}));
  const double f_px = 120 / std::tan(Camera().fov_y_rad / 2);
  const int reach = static_cast<int>(f_px / 3);
  EXPECT_EQ(image.at(160 - reach, 120), (Color{255, 255, 255})) << "the ring's middle";
  EXPECT_EQ(image.at(160 - reach, 120 - 8), kRed);
  EXPECT_EQ(image.at(160 + reach, 120), kRed);
  EXPECT_EQ(image.at(160 + reach, 120 - 8), kRed);
}

TEST_F(Drawing, keyframes_are_pyramids_at_their_places) {
  Scene scene;
  scene.robots = {{"robot1", kBlue, {}, {test::level_pose(0, 0, 3, 0)}}};
  style_.marker_size_m = 1;
  const Camera camera = camera_at({0, 0, 0}, {0, 0, 1});
  const Image image = draw(scene, camera);
  const double f_px = 120 / std::tan(camera.fov_y_rad / 2);
  // The base's edges at depth 3 + 1, half width 0.62: blue there, a tint inside, background outside.
  const int left = static_cast<int>(std::lround(160 - 0.62 * f_px / 4));
  int blueish = 0;
  for (int x = left - 2; x <= left + 2; ++x) blueish += image.at(x, 130)[0] < 120 ? 1 : 0;
  EXPECT_GT(blueish, 0);
  const Color inside = image.at(160, 110);
  EXPECT_LT(inside[0], style_.background[0]);
  EXPECT_GT(inside[0], 60);
  EXPECT_EQ(image.at(left - 6, 130), style_.background);
}

TEST_F(Drawing, shading_is_mild) {
  Scene scene = test::room_scene();
  scene.robots.clear();
  const Camera camera = make_camera(scene, View::front, 4.0f / 3);
  const Image flat = draw(scene, camera);
  style_.shading = Style().shading;
  const Image lit = draw(scene, camera);
  const auto difference = test::compare(flat, lit);
  EXPECT_GT(difference.mean, 2);
  EXPECT_LT(difference.mean, 40);
}

// A floor and a wall that meet, seen at a slant: the hollow is darker, the planes keep their colour.
TEST_F(Drawing, hollows_are_darker_and_planes_are_not) {
  Scene scene;
  const Color plain{200, 200, 200};
  test::add_tiles(scene.mesh, {-4, 1, 1}, {8, 0, 0}, {0, 0, 4}, 1, plain, plain);   // floor, y down
  test::add_tiles(scene.mesh, {-4, -3, 5}, {0, 4, 0}, {8, 0, 0}, 1, plain, plain);  // wall
  const Camera camera = camera_at({0, -0.5f, 0}, {0, 0.5f, 5});
  const Image flat = draw(scene, camera);
  style_.depth_cues = 1;
  const Image cued = draw(scene, camera);
  ASSERT_EQ(flat.at(160, 20), plain);
  ASSERT_EQ(flat.at(160, 230), plain);
  EXPECT_EQ(cued.at(160, 20), plain);
  EXPECT_NEAR(cued.at(160, 230)[0], 200, 2);
  int darkest = 255;
  for (int y = 100; y < 200; ++y) darkest = std::min(darkest, int{cued.at(160, y)[0]});
  EXPECT_LT(darkest, 185);
  EXPECT_GT(darkest, 45);
  EXPECT_EQ(cued.at(160, 120)[0] == cued.at(80, 120)[0], true) << "the same along the line";
}

// A wall as a depth camera measures it from four metres: bumps of up to 2 cm, a hand wide.
TEST_F(Drawing, a_walls_noise_is_no_stain) {
  Scene scene;
  constexpr std::uint32_t kSide = 61;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const auto bump = static_cast<float>((x * 7919 + y * 104729 + x * y * 31) % 41) / 41.0f - 0.5f;
      scene.mesh.vertices.emplace_back(0.06f * static_cast<float>(x) - 1.8f, 0.06f * static_cast<float>(y) - 1.8f,
                                       4 + 0.04f * bump);
      scene.mesh.colors.push_back({200, 200, 200});
    }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t a = y * kSide + x;
      scene.mesh.triangles.push_back({a, a + 1, a + kSide});
      scene.mesh.triangles.push_back({a + 1, a + kSide + 1, a + kSide});
    }
  style_.both_sides = true;
  const Camera camera = camera_at({0, 0, 0}, {0, 0, 4});
  const Image flat = draw(scene, camera);
  style_.depth_cues = Style().depth_cues;
  const auto stains = test::compare(flat, draw(scene, camera));
  EXPECT_LT(stains.mean, 3);  // of 200
  EXPECT_LT(stains.outliers, 0.05);
}

TEST_F(Drawing, every_robot_has_one_colour_in_every_picture) {
  const std::vector<std::string> team{"robot2", "robot1", "robot3"};
  const auto colors = robot_colors(team);
  for (std::size_t i = 0; i < team.size(); ++i) EXPECT_EQ(robot_colors({team[i]}).front(), colors[i]) << team[i];
  EXPECT_EQ(colors[1], robot_color(0));
  const auto clash = robot_colors({"r1", "s1", "t11", "kitchen"});
  for (std::size_t i = 0; i < clash.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(clash[i], clash[j]);
  Scene scene;
  scene.robots = {{"robot2", colors[0], {test::level_pose(-1, 0, 3, 0), test::level_pose(1, 0, 3, 0)}, {}}};
  const Image image = draw(scene, camera_at({0, 0, 0}, {0, 0, 1}));
  EXPECT_GT(count(image, colors[0]), 100u);
}

TEST_F(Drawing, at_most_fifteen_pyramids_a_robot_stand_in_a_picture) {
  Scene scene;
  RobotPath path{"robot1", kBlue, {}, {}};
  for (int i = 0; i < 400; ++i) path.keyframe_poses.push_back(test::level_pose(-2 + 0.01 * i, 0, 4, 0));
  scene.robots = {path};
  style_.width_px = 1280;
  style_.height_px = 720;
  style_.path_width_px = 0;
  const Image image = draw(scene, camera_at({0, -2, 0}, {0, 0, 4}));
  int pieces = 0;  // of blue along the row of their tips, or just below
  for (int y = 300; y < 420; ++y) {
    int here = 0;
    bool before = false;
    for (int x = 0; x < image.width; ++x) {
      const bool blue = image.at(x, y) == kBlue;
      here += blue && !before ? 1 : 0;
      before = blue;
    }
    pieces = std::max(pieces, here);
  }
  EXPECT_GE(pieces, 8);
  EXPECT_LE(pieces, 4 * 15);  // edges of a pyramid that a row can cross
}

TEST_F(Drawing, the_same_scene_gives_the_same_picture_in_every_renderer) {
  const Scene scene = test::room_scene();
  const Camera camera = make_camera(scene, View::fit, 4.0f / 3);
  const Image first = draw(scene, camera);
  auto other = open_egl_renderer();
  ASSERT_TRUE(other.ok());
  EXPECT_EQ((*other)->draw(scene, camera, style_)->rgb, first.rgb);
  other->reset();
  EXPECT_EQ(draw(scene, camera).rgb, first.rgb) << "closing one renderer must not hurt another";
}

// The border of a picture of a whole room is background; what is in the middle is not, and fills most of it.
TEST_F(Drawing, simulated_rooms_are_not_clipped_and_fill_the_picture) {
  const test::SimulatedRoom room = test::simulated_room("simulated:living-room?frames=120&fps=8&width=320&height=240");
  for (const View view : {View::fit, View::top, View::plan}) {
    const Image image = draw(room.scene, make_camera(room.scene, view, 4.0f / 3));
    int x0 = image.width, x1 = 0, y0 = image.height, y1 = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y) == style_.background) continue;
        x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
      }
    EXPECT_GE(x0, 6);
    EXPECT_LE(x1, image.width - 7);
    EXPECT_GE(y0, 5);
    EXPECT_LE(y1, image.height - 6);
    EXPECT_TRUE(x1 - x0 > image.width * 7 / 10 || y1 - y0 > image.height * 7 / 10);
  }
}

// The stored picture was looked at: a furnished room from behind three robots. ONEMAP_UPDATE_BASELINES=1 writes it
// anew.
TEST_F(Drawing, the_room_looks_as_it_was_approved) {
  const Scene scene = test::room_scene();
  style_.width_px = 480;
  style_.height_px = 270;
  style_.shading = Style().shading;
  style_.depth_cues = Style().depth_cues;
  for (const auto& [view, name] :
       {std::pair{View::fit, "fit"}, {View::top, "top"}, {View::plan, "plan"}, {View::follow, "follow"}}) {
    const Camera camera = make_camera(scene, view, 16.0f / 9);
    Image image = draw(scene, camera);
    draw_legend(image, scene, camera);
    const std::string path = std::string(ONEMAP_SOURCE_DIR) + "/tests/data/room_" + name + ".png";
    if (std::getenv("ONEMAP_UPDATE_BASELINES") != nullptr) {
      ASSERT_TRUE(write_png(path, image).ok());
    }
    const auto difference = test::compare(image, test::read_png(path));
    ASSERT_TRUE(difference.same_size) << path;
    EXPECT_LT(difference.mean, 1.0) << path;
    EXPECT_LT(difference.outliers, 0.01) << path;
  }
}

TEST_F(Drawing, refuses_what_it_cannot_draw_and_says_why) {
  Scene scene;
  scene.mesh.vertices = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  scene.mesh.triangles = {{0, 1, 3}};
  const Camera camera;
  auto image = renderer_->draw(scene, camera, style_);
  ASSERT_FALSE(image.ok());
  EXPECT_NE(image.error().text().find("vertex 3 of 3"), std::string::npos) << image.error().text();
  scene.mesh.triangles.clear();
  scene.mesh.colors = {kRed};
  EXPECT_FALSE(renderer_->draw(scene, camera, style_).ok());
  style_.width_px = 1 << 20;
  image = renderer_->draw(Scene(), camera, style_);
  ASSERT_FALSE(image.ok());
  EXPECT_NE(image.error().text().find("1048576 x 240"), std::string::npos) << image.error().text();
  style_.width_px = 320;
  EXPECT_EQ(count(draw(Scene(), camera), style_.background), 320u * 240u);
}

}  // namespace
}  // namespace onemap::render
