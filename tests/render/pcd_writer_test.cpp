#include "render/pcd_writer.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "hal/base/file.hpp"
#include "render/upright.hpp"
#include "room_scene.hpp"
#include "support/other_program.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

// A PCD file by its words: everything up to DATA, and what follows.
struct Pcd {
  std::map<std::string, std::string> header;
  std::string data;
};

Pcd parsed(const std::string& file) {
  const std::string text = *read_text_file(file), end = "DATA binary\n";
  const std::size_t at = text.find(end) + end.size();
  Pcd pcd;
  std::istringstream lines(text.substr(0, at));
  for (std::string line; std::getline(lines, line);)
    if (line[0] != '#') pcd.header[line.substr(0, line.find(' '))] = line.substr(line.find(' ') + 1);
  pcd.data = text.substr(at);
  return pcd;
}

template <class T>
T value_at(const std::string& data, std::size_t offset) {
  T value;
  std::memcpy(&value, data.data() + offset, sizeof(T));
  return value;
}

TEST(Pcd, the_layout_is_the_documented_one) {
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  const mapping::Matrix3d R = upright_rotation({0.1f, -0.9f, 0.2f});
  ASSERT_TRUE(write_pcd(folder / "room.pcd", mesh, R).ok());
  const Pcd pcd = parsed(folder / "room.pcd");
  const std::string count = std::to_string(mesh.vertices.size());
  EXPECT_EQ(pcd.header, (std::map<std::string, std::string>{{"VERSION", "0.7"},
                                                            {"FIELDS", "x y z rgb"},
                                                            {"SIZE", "4 4 4 4"},
                                                            {"TYPE", "F F F F"},
                                                            {"COUNT", "1 1 1 1"},
                                                            {"WIDTH", count},
                                                            {"HEIGHT", "1"},
                                                            {"VIEWPOINT", "0 0 0 1 0 0 0"},
                                                            {"POINTS", count},
                                                            {"DATA", "binary"}}));
  ASSERT_EQ(pcd.data.size(), 16 * mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const mapping::Vector3f p(value_at<float>(pcd.data, 16 * i), value_at<float>(pcd.data, 16 * i + 4),
                              value_at<float>(pcd.data, 16 * i + 8));
    ASSERT_LT((p - R.cast<float>() * mesh.vertices[i]).norm(), 1e-5f) << i;
    const auto& c = mesh.colors[i];
    ASSERT_EQ(value_at<std::uint32_t>(pcd.data, 16 * i + 12), c[0] * 65536u + c[1] * 256u + c[2]) << i;
  }
}

TEST(Pcd, clouds_without_colours_are_grey_and_torn_ones_are_not_written) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_pcd(folder / "c.pcd", mapping::ColoredCloud{{{1, 2, 3}}, {}, {}}).ok());
  const Pcd pcd = parsed(folder / "c.pcd");
  ASSERT_EQ(pcd.data.size(), 16u);
  EXPECT_EQ(pcd.data.substr(0, 4), std::string("\x00\x00\x80\x3f", 4)) << "little endian";
  EXPECT_EQ(value_at<std::uint32_t>(pcd.data, 12), 0xB4B4B4u);
  ASSERT_TRUE(write_pcd(folder / "none.pcd", mapping::ColoredCloud{}).ok());
  EXPECT_EQ(parsed(folder / "none.pcd").header.at("POINTS"), "0");
  const auto torn = write_pcd(folder / "torn.pcd", mapping::ColoredCloud{{{1, 2, 3}}, {}, {{1, 2, 3}, {4, 5, 6}}});
  ASSERT_FALSE(torn.ok());
  EXPECT_NE(torn.error().text().find("torn.pcd: cannot write"), std::string::npos) << torn.error().text();
  EXPECT_FALSE(std::filesystem::exists(folder / "torn.pcd"));
}

TEST(Pcd, open3d_reads_the_points_and_their_colours) {
  const std::string python = test::python_with("open3d");
  if (python.empty()) GTEST_SKIP() << "python3-open3d is not installed";
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  ASSERT_TRUE(write_pcd(folder / "room.pcd", mesh).ok());
  const test::Said said =
      test::say(python + " -c 'import open3d; c = open3d.io.read_point_cloud(\"" + (folder / "room.pcd") +
                "\"); print(\"read\", len(c.points), *c.points[5], *[round(255 * v) for v in c.colors[5]])'");
  ASSERT_EQ(said.status, 0) << said.output;
  const std::size_t at = said.output.find("read ");
  ASSERT_NE(at, std::string::npos) << said.output;
  std::istringstream words(said.output.substr(at + 5));
  std::size_t count = 0;
  float x = 0, y = 0, z = 0;
  int r = 0, g = 0, b = 0;
  words >> count >> x >> y >> z >> r >> g >> b;
  EXPECT_EQ(count, mesh.vertices.size());
  EXPECT_EQ(mapping::Vector3f(x, y, z), mesh.vertices[5]);
  EXPECT_EQ(r, mesh.colors[5][0]);
  EXPECT_EQ(g, mesh.colors[5][1]);
  EXPECT_EQ(b, mesh.colors[5][2]);
}

TEST(Pcd, pcl_reads_the_points_and_their_colours) {
  if (test::say("command -v pcl_convert_pcd_ascii_binary").status != 0) GTEST_SKIP() << "pcl-tools is not installed";
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  ASSERT_TRUE(write_pcd(folder / "room.pcd", mesh).ok());
  const test::Said said =
      test::say("pcl_convert_pcd_ascii_binary " + (folder / "room.pcd") + " " + (folder / "text.pcd") + " 0 9");
  ASSERT_EQ(said.status, 0) << said.output;
  const auto text = read_text_file(folder / "text.pcd");
  ASSERT_TRUE(text.ok()) << said.output;
  EXPECT_NE(text->find("FIELDS x y z rgb\n"), std::string::npos) << text->substr(0, 300);
  const std::string end = "DATA ascii\n";
  ASSERT_NE(text->find(end), std::string::npos) << text->substr(0, 300);
  std::istringstream words(text->substr(text->find(end) + end.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mapping::Vector3f p;
    std::string rgb;  // a float's bits: as a whole number, or as that float
    ASSERT_TRUE(words >> p.x() >> p.y() >> p.z() >> rgb) << i;
    ASSERT_EQ(p, mesh.vertices[i]) << i;
    const auto& c = mesh.colors[i];
    const std::uint32_t should = c[0] * 65536u + c[1] * 256u + c[2];
    const bool whole = rgb.find_first_not_of("0123456789") == std::string::npos;
    ASSERT_EQ(whole ? static_cast<std::uint32_t>(std::stoul(rgb))
                    : std::bit_cast<std::uint32_t>(std::strtof(rgb.c_str(), nullptr)),
              should)
        << i << ": " << rgb;
  }
  std::string more;
  EXPECT_FALSE(words >> more) << more;
}

}  // namespace
}  // namespace onemap::render
