#include "mapping/team/level_frame.hpp"

#include <gtest/gtest.h>

#include "support/box_room.hpp"
#include "support/kinect_lens.hpp"
#include "support/simulated_keyframes.hpp"

namespace onemap::mapping {
namespace {

// A rectangle of facets about a middle, spanned by two half sides; seen from where u x v points to.
void add_rectangle(std::vector<Facet>& out, const Vector3f& middle, const Vector3f& u, const Vector3f& v) {
  const Vector3f normal = u.cross(v).normalized();
  for (int i = -5; i <= 5; ++i)
    for (int j = -5; j <= 5; ++j)
      out.push_back({middle + u * (static_cast<float>(i) / 5) + v * (static_cast<float>(j) / 5), normal,
                     u.norm() * v.norm() / 25});
}

std::vector<Facet> room(const Pose& T) {  // floor 1.5 below, a table, a ceiling, walls at 15 degrees
  std::vector<Facet> out;
  const Vector3f c(0.9659f, 0, 0.2588f), s(-0.2588f, 0, 0.9659f), y(0, 1, 0);
  add_rectangle(out, {0, 1.5f, 0}, 3 * c, 2 * s);  // up is -y
  add_rectangle(out, {0, 0.8f, 0}, 1 * c, 1 * s);
  add_rectangle(out, {0, -1.1f, 0}, 2 * s, 3 * c);
  add_rectangle(out, 3 * c, 2 * s, 1.3f * y);
  add_rectangle(out, 2 * s, 1.3f * y, 3 * c);
  for (Facet& f : out) {
    f.point = (T * f.point.cast<double>()).cast<float>();
    f.normal = (T.R * f.normal.cast<double>()).cast<float>();
  }
  return out;
}

TEST(LevelFrame, StandsOnTheFloorAlongTheWalls) {
  const Pose T{test::rotation({1, 0, 0.2}, 0.3), {4, 5, 6}};
  const auto facets = room(T);
  const Vector3f up = up_of(facets, {0, -1, 0});
  const auto level = level_frame(facets, up);
  ASSERT_TRUE(level.has_value());
  EXPECT_NEAR((level->R * level->R.transpose() - Matrix3d::Identity()).norm(), 0, 1e-5);
  EXPECT_NEAR(level->R.determinant(), 1, 1e-5);
  EXPECT_NEAR((*level * (T * Vector3d(0, 1.5, 0))).z(), 0, 0.01) << "the floor, not the table";
  EXPECT_NEAR((*level * (T * Vector3d(1, 0.5, 1))).z(), 1, 0.01);
  EXPECT_NEAR((*level * Vector3d::Zero()).x(), 0, 1e-9) << "below the map's origin";
  const Vector3d wall = level->R * T.R * Vector3d(0.9659, 0, 0.2588);
  EXPECT_GT(std::max(std::abs(wall.x()), std::abs(wall.y())), 0.9999) << "along an axis";
  EXPECT_GT((level->R * Vector3d(0, 0, 1)).x(), 0.7) << "ahead is x, within an eighth of a turn";
}

TEST(LevelFrame, WithoutAFloorThereIsNone) {
  EXPECT_FALSE(level_frame({}, {0, -1, 0}).has_value());
  std::vector<Facet> walls;
  add_rectangle(walls, {0, 0, 2}, {0, 1, 0}, {1, 0, 0});
  EXPECT_FALSE(level_frame(walls, {0, -1, 0}).has_value());
  std::vector<Facet> ceiling = walls;
  add_rectangle(ceiling, {0, -2, 2}, {0, 0, 1}, {1, 0, 0});
  EXPECT_FALSE(level_frame(ceiling, {0, -1, 0}).has_value()) << "a ceiling faces down";
}

TEST(LevelFrame, AFewStrayPointsBelowTheFloorAreNoFloor) {
  auto facets = room({});
  for (int i = 0; i < 4; ++i) facets.push_back({{0.1f * static_cast<float>(i), 2.5f, 0}, {0, -1, 0}, 0.2f});
  const auto level = level_frame(facets, {0, -1, 0});
  ASSERT_TRUE(level.has_value());
  EXPECT_NEAR((*level * Vector3d(0, 1.5, 0)).z(), 0, 0.01);
}

TEST(LevelFrame, FacetsLieOnThePlanesThatTheGridSeesAndFaceTheCamera) {
  const hal::Intrinsics k = test::kinect_lens();
  const RayTable rays(k);
  const auto scene = test::box_room();
  const Pose pose{test::rotation({1, 3, 1}, 0.4), {0.2, 0.1, 0}};
  std::vector<Facet> facets;
  add_facets(test::depth_grid(test::cast_depth(scene, k, rays, pose), k), pose, facets);
  ASSERT_GT(facets.size(), 100u);
  std::size_t good = 0;
  for (const Facet& f : facets) {
    EXPECT_NEAR(f.normal.norm(), 1, 1e-5);
    EXPECT_GT(f.weight, 0);
    EXPECT_GT(f.normal.cast<double>().dot(pose.t - f.point.cast<double>()), 0);
    for (const test::Plane& plane : scene) {
      if (std::abs(plane.n.dot(f.point.cast<double>()) - plane.h) > 0.02) continue;
      good += plane.n.dot(f.normal.cast<double>()) < -0.995;  // 6 degrees: the grid's steps
      break;
    }
  }
  EXPECT_GT(good, facets.size() * 9 / 10);
}

}  // namespace
}  // namespace onemap::mapping
