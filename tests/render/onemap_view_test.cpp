#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>

#include "picture.hpp"
#include "render/compare.hpp"
#include "render/gltf_writer.hpp"
#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "render/renderer.hpp"
#include "room_scene.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

struct Ran {
  int status = -1;
  std::string output;  // both streams
};

Ran view(const std::string& arguments, const std::string& environment = "") {
  const std::string command = environment + " " + ONEMAP_BIN_DIR + "/onemap-view " + arguments + " 2>&1";
  Ran ran;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return ran;
  std::array<char, 4096> part{};
  while (fgets(part.data(), part.size(), pipe) != nullptr) ran.output += part.data();
  ran.status = WEXITSTATUS(pclose(pipe));
  return ran;
}

class OnemapView : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(ONEMAP_BIN_DIR "/onemap-view")) GTEST_SKIP() << "onemap-view is not built";
    scene_ = test::room_scene();
    ASSERT_TRUE(write_glb(folder_ / "room.glb", scene_).ok());
    ASSERT_TRUE(write_ply(folder_ / "room.ply", scene_.mesh).ok());
  }
  void expect_failure(const std::string& arguments, int status, const std::string& part) {
    const Ran ran = view(arguments);
    EXPECT_EQ(ran.status, status) << arguments << "\n" << ran.output;
    EXPECT_NE(ran.output.find(part), std::string::npos) << ran.output;
  }
  test::TempFolder folder_;
  Scene scene_;
};

TEST_F(OnemapView, draws_a_saved_model_as_the_library_draws_the_scene) {
  auto renderer = open_egl_renderer();
  if (!renderer) GTEST_SKIP() << "no EGL driver that draws without a display: " << renderer.error().text();
  Style style;
  style.width_px = 400;
  style.height_px = 300;
  for (const std::string name : {"fit", "top"}) {
    const Ran ran =
        view((folder_ / "room.glb") + " --size 400x300 --view " + name + " --plain --png " + (folder_ / "a.png"));
    ASSERT_EQ(ran.status, 0) << ran.output;
    const Camera camera = make_camera(scene_, *view_from_name(name), 400.0f / 300);
    EXPECT_LT(test::compare(test::read_png(folder_ / "a.png"), *(*renderer)->draw(scene_, camera, style)).mean, 0.05);
  }
  const Ran ran = view((folder_ / "room.ply") + " --size 400x300 --eye 0,-0.5,-3 --target 0,0,2 --plain --png " +
                       (folder_ / "b.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  scene_.robots.clear();
  const Camera camera = make_camera(scene_, {0, -0.5f, -3}, {0, 0, 2});
  EXPECT_LT(test::compare(test::read_png(folder_ / "b.png"), *(*renderer)->draw(scene_, camera, style)).mean, 0.05);
}

TEST_F(OnemapView, converts_and_reduces_to_points) {
  Ran ran =
      view((folder_ / "room.glb") + " --ply " + (folder_ / "out.ply") + " --glb " + (folder_ / "out.glb") + " --mesh");
  ASSERT_EQ(ran.status, 0) << ran.output;
  const auto written = read_ply(folder_ / "out.ply");
  EXPECT_EQ(written->triangles, scene_.mesh.triangles);
  for (std::size_t i = 0; i < written->vertices.size(); ++i)
    ASSERT_LT((written->vertices[i] - scene_.mesh.vertices[i]).norm(), 1e-5f) << "turned upright and back";
  EXPECT_EQ(read_glb(folder_ / "out.glb")->robots.size(), 3u);
  ran = view((folder_ / "room.ply") + " --points --ply " + (folder_ / "out.ply"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_TRUE(read_ply(folder_ / "out.ply")->triangles.empty());
  EXPECT_EQ(read_ply(folder_ / "out.ply")->vertices.size(), scene_.mesh.vertices.size());
  expect_failure((folder_ / "out.ply") + " --mesh --glb " + (folder_ / "x.glb"), 1, "has no triangles");
}

TEST_F(OnemapView, says_what_is_wrong_and_exits_accordingly) {
  const std::string room = folder_ / "room.ply";
  expect_failure("", 2, "MAP is required");
  expect_failure(room, 2, "--png, --glb, --ply or --pcd");
  expect_failure(room + " --png a.png --background blue", 2, "--background: blue is neither");
  expect_failure(room + " --ply a.ply --turntable 5", 2, "give --png");
  expect_failure(room + " --png a.png --turntable 5 --follow-all 3", 2, "--follow-all");
  expect_failure(room + " --png a.png --compare " + (folder_ / "none.ply"), 1, "none.ply: cannot read");
  expect_failure(room + " --png a.png --follow-all 3", 1, "no robot with keyframes");
  expect_failure(room + " --png a.png --view sideways", 2, "sideways");
  expect_failure(room + " --png a.png --size 12", 2, "--size: 12 is not WIDTHxHEIGHT");
  expect_failure(room + " --png a.png --size 99999x99999", 2, "--size: 99999x99999 is not");
  expect_failure(room + " --png a.png --shading nan", 2, "--shading");
  expect_failure(room + " --png a.png --point-size nan", 2, "--point-size");
  expect_failure(room + " --png a.png --eye 0,nan,0", 2, "--eye");
  expect_failure(room + " --png a.png --eye 0,0,0 --target inf,0,0", 2, "--target");
  expect_failure(room + " --png a.png --target 1,2,3", 2, "--eye");
  expect_failure(room + " --points --mesh --ply a.ply", 2, "--points");
  expect_failure((folder_ / "none.ply") + " --ply a.ply", 1, "none.ply: cannot read: No such file");
  expect_failure(room + " --ply /no/such/folder/a.ply", 1,
                 "/no/such/folder/a.ply: cannot write: folder '/no/such/folder': No such file");
  expect_failure(std::string(ONEMAP_SOURCE_DIR) + "/README.md --ply a.ply", 1, "neither a .ply, a .glb nor an .omap");
  expect_failure((folder_ / "b\xff\x1b.ply") + " --ply a.ply", 1, "b\\xff\\x1b.ply: cannot read");
  const Ran help = view("--help");
  EXPECT_EQ(help.status, 0);
  EXPECT_NE(help.output.find("--turntable 120"), std::string::npos) << "examples";
}

TEST_F(OnemapView, draws_sequences_that_ffmpeg_takes) {
  if (!open_egl_renderer()) GTEST_SKIP() << "no EGL driver that draws without a display";
  Ran ran = view((folder_ / "room.glb") + " --size 64x48 --turntable 4 --png " + (folder_ / "turn.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  for (const char* name : {"turn_0000.png", "turn_0003.png"})
    EXPECT_EQ(test::read_png(folder_ / name).width, 64) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "turn_0004.png"));
  EXPECT_GT(test::compare(test::read_png(folder_ / "turn_0000.png"), test::read_png(folder_ / "turn_0001.png")).mean,
            5);
  ran = view((folder_ / "room.glb") + " --size 64x48 --follow-all 30 --png " + (folder_ / "way.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;  // 61 places: 0, 30, 60 of each robot
  EXPECT_TRUE(std::filesystem::exists(folder_ / "way_robot3_0002.png")) << ran.output;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "way_robot3_0003.png"));
}

TEST_F(OnemapView, draws_pictures_for_papers_and_several_views_at_once) {
  if (!open_egl_renderer()) GTEST_SKIP() << "no EGL driver that draws without a display";
  const std::string start = (folder_ / "room.glb") + " --size 320x240 --plain --png ";
  const Color color = scene_.robots[0].color;
  const auto pixels = [&](const std::string& more) {
    const Ran ran = view(start + (folder_ / "p.png") + more);
    EXPECT_EQ(ran.status, 0) << ran.output;
    const Image image = test::read_png(folder_ / "p.png");
    EXPECT_EQ(image.at(2, 2), more.find("white") != std::string::npos ? (Color{255, 255, 255}) : Style().background);
    std::size_t count = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) count += image.at(x, y) == color ? 1 : 0;
    return count;
  };
  const std::size_t none = pixels(" --background white --path-width 0"), thin = pixels("");
  EXPECT_GT(thin, none + 20);
  EXPECT_GT(pixels(" --background white --path-width 8"), 2 * thin);
  const Ran ran = view(start + (folder_ / "v.png") + " --views fit top plan");
  ASSERT_EQ(ran.status, 0) << ran.output;
  const Image fit = test::read_png(folder_ / "v_fit.png"), top = test::read_png(folder_ / "v_top.png"),
              plan = test::read_png(folder_ / "v_plan.png");
  EXPECT_GT(test::compare(fit, top).mean, 5);
  EXPECT_GT(test::compare(top, plan).mean, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "v.png"));
}

TEST_F(OnemapView, the_scale_of_a_comparison_and_the_legend_are_drawn) {
  if (!open_egl_renderer()) GTEST_SKIP() << "no EGL driver that draws without a display";
  const std::string start = (folder_ / "room.glb") + " --size 320x240 --png ";
  const auto picture = [&](const std::string& more) {
    const Ran ran = view(start + (folder_ / "p.png") + more);
    EXPECT_EQ(ran.status, 0) << ran.output;
    return test::read_png(folder_ / "p.png");
  };
  const Image plain = picture(" --plain"), legend = picture("");
  EXPECT_GT(test::compare(plain, legend).mean, 1);
  const Image compared = picture(" --plain --compare " + (folder_ / "room.ply"));
  const mapping::Rgb limit = distance_color(0.05f, 0.05f);
  const auto count = [&](const mapping::Rgb& color, int x0, int x1) {
    std::size_t n = 0;
    for (int y = 0; y < compared.height; ++y)
      for (int x = x0; x < x1; ++x) n += compared.at(x, y) == color ? 1 : 0;
    return n;
  };
  EXPECT_GT(count(limit, 250, 320), 0u) << "at the top of the scale, though nothing in the map is that far";
  EXPECT_EQ(count(limit, 0, 250), 0u);
}

TEST_F(OnemapView, compares_two_maps_and_puts_maps_beside_each_other) {
  if (!open_egl_renderer()) GTEST_SKIP() << "no EGL driver that draws without a display";
  Scene moved = scene_;
  moved.robots.clear();
  moved.mesh = {};
  test::add_tiles(moved.mesh, {-1, 1.48f, 0}, {0, 0, 3}, {2, 0, 0}, 20, {90, 90, 90}, {90, 90, 90});  // above the floor
  ASSERT_TRUE(write_ply(folder_ / "moved.ply", moved.mesh).ok());
  Scene floor;
  test::add_tiles(floor.mesh, {-2, 1.5f, -1}, {0, 0, 5}, {4, 0, 0}, 200, {90, 90, 90}, {90, 90, 90});
  ASSERT_TRUE(write_ply(folder_ / "floor.ply", floor.mesh).ok());
  Ran ran = view((folder_ / "moved.ply") + " --compare " + (folder_ / "floor.ply") + " --size 320x240 --png " +
                 (folder_ / "c.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_NE(ran.output.find("median 20.0 mm"), std::string::npos) << ran.output;
  EXPECT_EQ(ran.output.find("in one frame?"), std::string::npos) << ran.output;
  ran = view((folder_ / "moved.ply") + " --compare " + (folder_ / "floor.ply") +
             " --compare-limit 0.01 --size 320x240" + " --png " + (folder_ / "c.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_NE(ran.output.find("in one frame?"), std::string::npos) << ran.output;
  ran = view((folder_ / "room.glb") + " --beside " + (folder_ / "floor.ply") + " " + (folder_ / "moved.ply") +
             " --size 600x200 --png " + (folder_ / "three.png"));
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_EQ(test::read_png(folder_ / "three.png").width, 600);
}

TEST_F(OnemapView, without_a_driver_the_error_is_clear_and_other_formats_still_work) {
  const std::string no_driver = "__EGL_VENDOR_LIBRARY_FILENAMES=/dev/null";
  const Ran picture = view((folder_ / "room.ply") + " --png " + (folder_ / "a.png"), no_driver);
  EXPECT_EQ(picture.status, 1) << picture.output;
  EXPECT_NE(picture.output.find("EGL: no driver that draws without a display"), std::string::npos) << picture.output;
  EXPECT_EQ(view((folder_ / "room.ply") + " --glb " + (folder_ / "a.glb"), no_driver).status, 0);
}

}  // namespace
}  // namespace onemap::render
