#include "render/tidy.hpp"

#include <gtest/gtest.h>

namespace onemap::render {
namespace {

using mapping::Rgb;
using mapping::TriangleMesh;

// A strip of n x n shared vertices at a place.
void add_sheet(TriangleMesh& mesh, float x0, std::uint32_t n, Rgb color) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh.vertices.emplace_back(x0 + 0.02f * static_cast<float>(i), 0.02f * static_cast<float>(j), 1.0f);
      mesh.normals.emplace_back(0.0f, 0.0f, -1.0f);
      mesh.colors.push_back(color);
    }
  for (std::uint32_t j = 0; j + 1 < n; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = first + j * n + i;
      mesh.triangles.push_back({a, a + n, a + 1});
      mesh.triangles.push_back({a + 1, a + n, a + n + 1});
    }
}

TEST(Tidy, small_pieces_and_unused_vertices_go_and_the_rest_stays_in_order) {
  TriangleMesh mesh;
  add_sheet(mesh, 5, 10, {1, 2, 3});  // 100 vertices: a crumb
  add_sheet(mesh, 0, 20, {200, 0, 0});
  mesh.vertices.emplace_back(50.0f, 0.0f, 0.0f);
  mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
  mesh.colors.push_back({9, 9, 9});
  add_sheet(mesh, 2, 15, {0, 200, 0});  // 225 vertices: stays
  const TriangleMesh tidy = without_crumbs(mesh);
  ASSERT_EQ(tidy.vertices.size(), 400u + 225u);
  ASSERT_EQ(tidy.normals.size(), tidy.vertices.size());
  ASSERT_EQ(tidy.triangles.size(), 2u * (19 * 19 + 14 * 14));
  EXPECT_EQ(tidy.vertices.front(), mesh.vertices[100]);
  EXPECT_EQ(tidy.colors.front(), (Rgb{200, 0, 0}));
  EXPECT_EQ(tidy.colors.back(), (Rgb{0, 200, 0}));
  for (const auto& t : tidy.triangles)
    for (const auto i : t) ASSERT_LT(i, tidy.vertices.size());
  EXPECT_EQ(without_crumbs(mesh, 50).vertices.size(), 400u + 225u + 100u);
  EXPECT_EQ(without_crumbs(mesh, 0).vertices.size(), 400u + 225u + 100u);
}

TEST(Tidy, the_largest_piece_stays_however_small_and_clouds_are_left_alone) {
  TriangleMesh mesh;
  add_sheet(mesh, 0, 5, {7, 7, 7});
  add_sheet(mesh, 3, 4, {7, 7, 7});
  EXPECT_EQ(without_crumbs(mesh).vertices.size(), 25u);
  mesh.triangles.clear();
  EXPECT_EQ(without_crumbs(mesh).vertices.size(), 41u);
  EXPECT_TRUE(without_crumbs({}).vertices.empty());
}

TEST(Tidy, black_vertices_take_their_neighbours_colour_and_dark_ones_stay) {
  TriangleMesh mesh;
  add_sheet(mesh, 0, 9, {100, 60, 20});
  for (const std::size_t i : {40u, 41u, 31u}) mesh.colors[i] = {0, 0, 0};
  mesh.colors[0] = {0, 0, 1};
  colour_black_vertices(mesh);
  for (const std::size_t i : {40u, 41u, 31u}) EXPECT_EQ(mesh.colors[i], (Rgb{100, 60, 20}));
  EXPECT_EQ(mesh.colors[0], (Rgb{0, 0, 1}));
  TriangleMesh dark;
  add_sheet(dark, 0, 4, {0, 0, 0});
  colour_black_vertices(dark);
  EXPECT_EQ(dark.colors[5], (Rgb{0, 0, 0}));
}

}  // namespace
}  // namespace onemap::render
