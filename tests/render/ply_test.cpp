#include <gtest/gtest.h>

#include <sstream>

#include "hal/base/file.hpp"
#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "room_scene.hpp"
#include "support/other_program.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

Result<mapping::TriangleMesh> parse(const std::string& text) {
  return parse_ply({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, "test.ply");
}

void expect_error(const std::string& text, const std::string& part) {
  const auto mesh = parse(text);
  ASSERT_FALSE(mesh.ok()) << part;
  EXPECT_NE(mesh.error().text().find(part), std::string::npos) << mesh.error().text();
}

TEST(Ply, a_mesh_comes_back_as_written) {
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  ASSERT_TRUE(write_ply(folder / "room.ply", mesh).ok());
  const auto back = read_ply(folder / "room.ply");
  ASSERT_TRUE(back.ok()) << back.error().text();
  EXPECT_EQ(back->vertices, mesh.vertices);
  EXPECT_EQ(back->normals, mesh.normals);
  EXPECT_EQ(back->colors, mesh.colors);
  EXPECT_EQ(back->triangles, mesh.triangles);
}

// Every vertex, normal, colour and triangle, a line each, in as many digits as a float has.
constexpr const char* kSayMesh = R"(
import open3d, sys
m = open3d.io.read_triangle_mesh(sys.argv[1])
print("read", len(m.vertices), len(m.triangles))
for v, n, c in zip(m.vertices, m.vertex_normals, m.vertex_colors):
    print(*["%.9g" % x for x in (*v, *n)], *[round(255 * x) for x in c])
for t in m.triangles:
    print(*t)
)";

TEST(Ply, open3d_reads_vertices_normals_colours_and_triangles) {
  const std::string python = test::python_with("open3d");
  if (python.empty()) GTEST_SKIP() << "python3-open3d is not installed";
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  ASSERT_TRUE(write_ply(folder / "room.ply", mesh).ok());
  folder.write("say.py", kSayMesh);
  const test::Said said = test::say(python + " " + (folder / "say.py") + " " + (folder / "room.ply"));
  ASSERT_EQ(said.status, 0) << said.output;
  const std::size_t at = said.output.find("read ");
  ASSERT_NE(at, std::string::npos) << said.output;
  std::istringstream words(said.output.substr(at + 5));
  std::size_t vertices = 0, triangles = 0;
  ASSERT_TRUE(words >> vertices >> triangles);
  ASSERT_EQ(vertices, mesh.vertices.size());
  ASSERT_EQ(triangles, mesh.triangles.size());
  for (std::size_t i = 0; i < vertices; ++i) {
    mapping::Vector3f p, n;
    std::array<int, 3> c{};
    ASSERT_TRUE(words >> p.x() >> p.y() >> p.z() >> n.x() >> n.y() >> n.z() >> c[0] >> c[1] >> c[2]) << i;
    ASSERT_EQ(p, mesh.vertices[i]) << i;
    ASSERT_EQ(n, mesh.normals[i]) << i;
    ASSERT_EQ(c, (std::array<int, 3>{mesh.colors[i][0], mesh.colors[i][1], mesh.colors[i][2]})) << i;
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    std::array<std::uint32_t, 3> t{};
    ASSERT_TRUE(words >> t[0] >> t[1] >> t[2]) << i;
    ASSERT_EQ(t, mesh.triangles[i]) << i;
  }
}

TEST(Ply, a_cloud_without_normals_comes_back_and_missing_colours_become_grey) {
  const test::TempFolder folder;
  const mapping::ColoredCloud cloud{{{1, 2, 3}, {-4, 5.5f, 6}}, {}, {{1, 2, 3}, {254, 255, 0}}};
  ASSERT_TRUE(write_ply(folder / "c.ply", cloud).ok());
  auto back = read_ply(folder / "c.ply");
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->vertices, cloud.points);
  EXPECT_EQ(back->colors, cloud.colors);
  EXPECT_TRUE(back->normals.empty());
  EXPECT_TRUE(back->triangles.empty());
  ASSERT_TRUE(write_ply(folder / "c.ply", mapping::ColoredCloud{cloud.points, {}, {}}).ok());
  back = read_ply(folder / "c.ply");
  EXPECT_EQ(back->colors[0], (mapping::Rgb{180, 180, 180}));
}

TEST(Ply, the_layout_is_the_documented_one) {
  const test::TempFolder folder;
  const mapping::TriangleMesh mesh{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, {{0, 1, 2}}};
  ASSERT_TRUE(write_ply(folder / "t.ply", mesh).ok());
  const auto bytes = *read_file(folder / "t.ply");
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_EQ(text.substr(0, text.find("end_header\n")),
            "ply\nformat binary_little_endian 1.0\ncomment metres, y down\nelement vertex 3\nproperty float x\n"
            "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "element face 1\nproperty list uchar uint vertex_indices\n");
  const std::string data = text.substr(text.find("end_header\n") + 11);
  ASSERT_EQ(data.size(), 3 * 15 + 13u);
  EXPECT_EQ(data.substr(0, 4), std::string("\x00\x00\x80\x3f", 4));  // 1.0f, little endian
  EXPECT_EQ(data.substr(12, 3), "\x01\x02\x03");
  EXPECT_EQ(data.substr(45), std::string("\x03\0\0\0\0\1\0\0\0\2\0\0\0", 13));
}

TEST(Ply, reads_ascii_other_orders_unknown_parts_and_polygons) {
  const auto mesh = parse(
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement camera 1\r\nproperty float f\r\nproperty list uchar int "
      "k\r\n"
      "element vertex 4\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\nproperty uchar "
      "alpha\r\n"
      "property double z\r\nproperty double y\r\nproperty double x\r\nelement face 1\r\n"
      "property list uchar int vertex_indices\r\nend_header\r\n"
      "2.5 2 7 8\r\n9 8 7 255 3 2 1\r\n0 0 0 0 0 0 0\r\n1 1 1 1 1e0 -1 1\r\n2 2 2 2 2 2 2\r\n4 0 1 2 3\r\n");
  ASSERT_TRUE(mesh.ok()) << mesh.error().text();
  ASSERT_EQ(mesh->vertices.size(), 4u);
  EXPECT_EQ(mesh->vertices[0], mapping::Vector3f(1, 2, 3));
  EXPECT_EQ(mesh->vertices[2], mapping::Vector3f(1, -1, 1));
  EXPECT_EQ(mesh->colors[0], (mapping::Rgb{9, 8, 7}));
  using Triangle = std::array<std::uint32_t, 3>;
  EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Ply, refuses_what_is_wrong_and_says_where) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  expect_error("", "not a PLY");
  expect_error("solid\nend_header\n", "not a PLY");
  expect_error("ply\nformat binary_big_endian 1.0\nend_header\n", "test.ply:2: format binary_big_endian");
  expect_error("ply\nelement vertex 0\nproperty float x\nend_header\n", "no format");
  expect_error("ply\nformat ascii 1.0\nelement vertex two\nend_header\n", "test.ply:3: a count");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n", "test.ply:4: an unknown");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "no x, y, z");
  expect_error("ply\nformat ascii 1.0\nend_header\n", "no vertices");
  expect_error(head + "end_header\n1 2\n", "vertex 0 of 1");
  expect_error(head + "end_header\n1 2 banana\n", "not a number");
  expect_error(head + "end_header\n1 2 nan\n", "not finite");
  expect_error(head + face + "end_header\n1 2 3\n3 0 0 1\n", "vertex 1 of 1");
  expect_error(head + face + "end_header\n1 2 3\n3 0 0 -1\n", "vertex 4294967295 of 1");
  expect_error(
      "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n0123456789ab",
      "vertex 1 of");
}

TEST(Ply, any_cut_or_flipped_byte_gives_a_valid_mesh_or_an_error) {
  const test::TempFolder folder;
  const mapping::TriangleMesh mesh{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, {{0, 1, 2}}};
  ASSERT_TRUE(write_ply(folder / "t.ply", mesh).ok());
  const auto whole = *read_file(folder / "t.ply");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_ply({whole.data(), size}, "cut").ok()) << size;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const std::uint8_t flip : {1, 16, 128, 255}) {
      auto broken = whole;
      broken[at] ^= flip;
      const auto parsed = parse_ply(broken, "flipped");
      if (!parsed) continue;
      for (const auto& triangle : parsed->triangles)
        for (const auto index : triangle) ASSERT_LT(index, parsed->vertices.size());
    }
  }
}

TEST(Ply, a_map_with_torn_parts_is_not_written) {
  const auto written = write_ply("/tmp/never.ply", mapping::ColoredCloud{{{1, 2, 3}}, {}, {{1, 2, 3}, {4, 5, 6}}});
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().text().find("/tmp/never.ply: cannot write"), std::string::npos);
}

}  // namespace
}  // namespace onemap::render
