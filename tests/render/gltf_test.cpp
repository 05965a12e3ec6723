#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

#include "hal/base/file.hpp"
#include "render/gltf_writer.hpp"
#include "room_scene.hpp"
#include "simulated_room.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

Scene cloud_scene() {
  Scene scene;
  scene.title = "cloud";
  scene.points = {{{1, 2, 3}, {-4, 5.5f, 6}}, {{0, 0, 0}, {0, 3, 4}}, {{1, 2, 3}, {254, 128, 0}}};
  scene.robots = {{"one", robot_color(0), {test::level_pose(0, 0, 0, 0)}, {test::level_pose(1, 2, 3, 0.5)}}};
  return scene;
}

void expect_same_poses(const std::vector<mapping::Pose>& a, const std::vector<mapping::Pose>& b, bool rotations) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT((a[i].t - b[i].t).norm(), 1e-6);
    EXPECT_TRUE(!rotations || (a[i].R - b[i].R).norm() < 1e-9);
  }
}

TEST(Gltf, a_scene_comes_back_as_written) {
  const test::TempFolder folder;
  const Scene scene = test::room_scene();
  ASSERT_TRUE(write_glb(folder / "room.glb", scene).ok());
  const auto back = read_glb(folder / "room.glb");
  ASSERT_TRUE(back.ok()) << back.error().text();
  EXPECT_EQ(back->title, "room");
  EXPECT_EQ(back->mesh.vertices, scene.mesh.vertices);
  EXPECT_EQ(back->mesh.colors, scene.mesh.colors) << "every 8-bit colour survives the linear encoding";
  EXPECT_EQ(back->mesh.triangles, scene.mesh.triangles);
  EXPECT_EQ(back->mesh.normals.size(), scene.mesh.normals.size());
  ASSERT_EQ(back->robots.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back->robots[i].name, scene.robots[i].name);
    EXPECT_EQ(back->robots[i].color, scene.robots[i].color);
    expect_same_poses(back->robots[i].poses, scene.robots[i].poses, false);
    expect_same_poses(back->robots[i].keyframe_poses, scene.robots[i].keyframe_poses, true);
  }
}

TEST(Gltf, all_colours_survive) {
  const test::TempFolder folder;
  Scene scene;
  for (int i = 0; i < 256; ++i) {
    scene.points.points.emplace_back(static_cast<float>(i), 0.0f, 0.0f);
    scene.points.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i), 7});
  }
  ASSERT_TRUE(write_glb(folder / "c.glb", scene).ok());
  EXPECT_EQ(read_glb(folder / "c.glb")->points.colors, scene.points.colors);
}

// The JSON part as any other reader sees it, by the container's own layout: 12 bytes header, then length, type, JSON.
nlohmann::json json_of(const std::vector<std::uint8_t>& glb) {
  const auto word = [&](std::size_t at) {
    return glb[at] | (std::uint32_t{glb[at + 1]} << 8) | (std::uint32_t{glb[at + 2]} << 16) |
           (std::uint32_t{glb[at + 3]} << 24);
  };
  EXPECT_EQ(word(0), 0x46546C67u);
  EXPECT_EQ(word(4), 2u);
  EXPECT_EQ(word(8), glb.size());
  const auto begin = glb.begin() + 20;
  return nlohmann::json::parse(begin, begin + static_cast<std::ptrdiff_t>(word(12)));
}

TEST(Gltf, nodes_have_the_documented_names_and_stand_upright) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_glb(folder / "room.glb", test::room_scene()).ok());
  const auto json = json_of(*read_file(folder / "room.glb"));
  const auto& root = json["nodes"][json["scenes"][0]["nodes"][0].get<std::size_t>()];
  EXPECT_EQ(root["name"], "room");
  const auto rotation = root["rotation"].get<std::vector<double>>();  // half a turn about x: y down becomes y up
  EXPECT_NEAR(std::abs(rotation[0]), 1, 1e-4);
  for (const std::size_t i : {1u, 2u, 3u}) EXPECT_NEAR(rotation[i], 0, 1e-4);
  EXPECT_FALSE(json["materials"][0].value("doubleSided", false)) << "a doll's house: one looks through the walls";
  EXPECT_TRUE(json["materials"][1].value("doubleSided", false)) << "a robot's pyramids are seen from everywhere";
  std::vector<std::string> names;
  for (const auto& child : root["children"]) names.push_back(json["nodes"][child.get<std::size_t>()]["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{"map", "trajectory robot1", "cameras robot1", "trajectory robot2",
                                             "cameras robot2", "trajectory robot3", "cameras robot3"}));
  EXPECT_EQ(json["extensionsUsed"][0], "KHR_materials_unlit");
  const auto& primitive = json["meshes"][0]["primitives"][0];
  const auto& position = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_EQ(position["min"], (std::vector<double>{-2, -1, -1}));
  EXPECT_EQ(position["max"], (std::vector<double>{2, 1.5, 4}));
  EXPECT_TRUE(json["accessors"][primitive["attributes"]["COLOR_0"].get<std::size_t>()]["normalized"].get<bool>());
}

TEST(Gltf, the_same_scene_gives_the_same_bytes) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_glb(folder / "a.glb", test::room_scene()).ok());
  ASSERT_TRUE(write_glb(folder / "b.glb", test::room_scene()).ok());
  EXPECT_EQ(*read_file(folder / "a.glb"), *read_file(folder / "b.glb"));
}

TEST(Gltf, refuses_points_that_are_nowhere_and_torn_maps) {
  Scene scene = cloud_scene();
  scene.points.points[0].x() = std::numeric_limits<float>::quiet_NaN();
  auto written = write_glb("/tmp/never.glb", scene);
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().text().find("/tmp/never.glb: cannot write: the map has a point that is not finite"),
            std::string::npos);
  scene = cloud_scene();
  scene.points.colors.pop_back();
  EXPECT_FALSE(write_glb("/tmp/never.glb", scene).ok());
  scene = cloud_scene();
  scene.robots[0].keyframe_poses[0].t.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(write_glb("/tmp/never.glb", scene).ok());
  written = write_glb("/no/such/folder/a.glb", cloud_scene());
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().text(),
            "/no/such/folder/a.glb: cannot write: folder '/no/such/folder': No such file or directory");
}

TEST(Gltf, broken_files_give_errors_and_valid_meshes_only) {
  const test::TempFolder folder;
  Scene small = cloud_scene();
  small.mesh = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, {{0, 1, 2}}};
  ASSERT_TRUE(write_glb(folder / "a.glb", small).ok());
  const auto whole = *read_file(folder / "a.glb");
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    ASSERT_TRUE(write_file(folder / "cut.glb", {whole.data(), size}).ok());
    EXPECT_FALSE(read_glb(folder / "cut.glb").ok()) << size;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto broken = whole;
    broken[at] ^= at % 2 == 0 ? 1 : 3;
    ASSERT_TRUE(write_file(folder / "flipped.glb", broken).ok());
    const auto scene = read_glb(folder / "flipped.glb");
    if (!scene) continue;
    for (const auto& triangle : scene->mesh.triangles)
      for (const auto index : triangle) ASSERT_LT(index, scene->mesh.vertices.size());
  }
}

// Where node finds packages: the folder named by the variable, else the global ones.
std::string packages_in(const char* variable) {
  const char* place = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): tests have one thread
  return place != nullptr ? std::string(place) : std::string("\"$(npm root -g 2>/dev/null)/..\"");
}

std::string node_in(const std::string& folder) {
  return "cd " + folder + " 2>/dev/null && command -v node >/dev/null || exit 77; node " + ONEMAP_SOURCE_DIR;
}

struct Answer {
  int status = 0;
  std::string output;
};
Answer answer_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {1, "no pipe"};
  Answer out;
  std::array<char, 4096> part{};
  while (fgets(part.data(), part.size(), pipe) != nullptr) out.output += part.data();
  out.status = WEXITSTATUS(pclose(pipe));
  return out;
}

// Khronos' validator, when somebody installed it: in the folder named by ONEMAP_GLTF_VALIDATOR or globally.
TEST(Gltf, the_khronos_validator_accepts_every_kind_of_scene) {
  const test::TempFolder folder;
  Scene paths_only, untouched;
  paths_only.robots = test::room_scene().robots;
  ASSERT_TRUE(write_glb(folder / "room.glb", test::room_scene()).ok());
  ASSERT_TRUE(write_glb(folder / "cloud.glb", cloud_scene()).ok());
  ASSERT_TRUE(write_glb(folder / "paths.glb", paths_only).ok());
  ASSERT_TRUE(write_glb(folder / "empty.glb", untouched).ok());
  const std::string enter = packages_in("ONEMAP_GLTF_VALIDATOR");
  const std::string command = node_in(enter) + "/tests/render/validate_gltf.mjs " + (folder / "*.glb") + " 2>&1";
  const auto [status, output] = answer_of(command);
  if (status == 77) GTEST_SKIP() << "Khronos' glTF validator is not installed (npm install -g gltf-validator)";
  EXPECT_EQ(status, 0) << output;
  EXPECT_NE(output.find("room.glb: 0 errors, 0 warnings"), std::string::npos) << output;
}

// A simulated room in three.js in headless Chromium, where both are installed: three in the folder named by
// ONEMAP_THREE or globally.
TEST(Gltf, three_js_shows_a_room_upright_and_within_the_frame) {
  const test::TempFolder folder;
  const Scene room = test::simulated_room("simulated:office?frames=60&width=320&height=240").scene;
  ASSERT_TRUE(write_glb(folder / "room.glb", room).ok());
  const auto [status, output] = answer_of(node_in(packages_in("ONEMAP_THREE")) + "/tests/render/view_gltf.mjs " +
                                          (folder / "room.glb") + " 2>&1");
  if (status == 77) GTEST_SKIP() << "three.js or Chromium is not installed (npm install -g three, apt: chromium)";
  ASSERT_EQ(status, 0) << output;
  const auto says = nlohmann::json::parse(output);
  EXPECT_LT(says["tilt_deg"].get<double>(), 3) << output;
  EXPECT_EQ(says["at_rim"].get<int>(), 0) << output;
  EXPECT_GT(says["shown"].get<double>(), 0.05) << output;
  EXPECT_GE(says["triangles"].get<std::size_t>(), room.mesh.triangles.size()) << output;  // and the cameras'
}

}  // namespace
}  // namespace onemap::render
