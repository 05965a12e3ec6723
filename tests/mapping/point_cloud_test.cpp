#include "mapping/local/point_cloud.hpp"

#include <gtest/gtest.h>

#include "mapping/local/lens.hpp"
#include "support/box_room.hpp"

namespace onemap::mapping {
namespace {

hal::Intrinsics kinect() {
  return {.fx = 517.306408,
          .fy = 516.469215,
          .cx = 318.643040,
          .cy = 255.313989,
          .k1 = 0.262383,
          .k2 = -0.953104,
          .p1 = -0.005358,
          .p2 = 0.002628,
          .k3 = 1.163314};
}

TEST(PointCloud, RayTableInvertsTheLens) {
  const hal::Intrinsics k = kinect();
  const RayTable rays(k);
  for (int v = 0; v < k.height; v += 13) {
    for (int u = 0; u < k.width; u += 11) {
      const float* ray = rays.row(v) + 2 * u;
      const Eigen::Vector2d back = distorted_pixel(k, {ray[0], ray[1]});
      EXPECT_NEAR(back.x(), u, 1e-3);
      EXPECT_NEAR(back.y(), v, 1e-3);
    }
  }
  const Eigen::Vector2d between = distorted_pixel(k, rays.at(200.25, 99.75));
  EXPECT_NEAR(between.x(), 200.25, 2e-3);
  EXPECT_NEAR(between.y(), 99.75, 2e-3);
  EXPECT_EQ(rays.at(-5, 1000), rays.at(0, k.height - 1));  // outside: the border's ray
}

TEST(PointCloud, ToPointsFollowsEquationFive) {
  const hal::Intrinsics k;  // no distortion
  const RayTable rays(k);
  std::vector<std::uint16_t> depth(640 * 480, 0);
  depth[10 * 640 + 20] = 10000;  // 2 m
  depth[10 * 640 + 24] = 249;    // under 0.05 m: no measurement
  depth[12 * 640 + 30] = 40001;  // over 8 m
  depth[12 * 640 + 31] = 5000;   // between the strides
  std::vector<Vector3f> out(10);
  ASSERT_EQ(to_points(depth, rays, k.depth_scale, 2, out), 1u);
  EXPECT_NEAR(out[0].x(), (20 - k.cx) / k.fx * 2, 1e-6);
  EXPECT_NEAR(out[0].y(), (10 - k.cy) / k.fy * 2, 1e-6);
  EXPECT_FLOAT_EQ(out[0].z(), 2);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, 1, out), 2u);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, 1, std::span(out).first(1)), 1u);
}

TEST(PointCloud, OrganizedPlanesHaveTheirPointsAndNormals) {
  const hal::Intrinsics k = kinect();
  const RayTable rays(k);
  const auto scene = test::box_room();
  Pose camera;
  camera.R = test::rotation({1, 3, 1}, 0.4);
  const auto depth = test::cast_depth(scene, k, rays, camera);
  for (const int width : {160, 320}) {
    OrganizedCloud cloud;
    organize(depth, k, width, width * 3 / 4, cloud);
    int with_normal = 0, off_plane = 0, off_normal = 0;
    for (int v = 0; v < cloud.height; ++v) {
      for (int u = 0; u < cloud.width; ++u) {
        const auto i = static_cast<std::size_t>(v * cloud.width + u);
        const Vector3f& p = cloud.points[i];
        if (p.z() == 0) continue;
        EXPECT_NEAR(p.x() / p.z(), (static_cast<float>(u) - cloud.cx) / cloud.fx, 0.6 / k.fx);
        EXPECT_NEAR(p.y() / p.z(), (static_cast<float>(v) - cloud.cy) / cloud.fy, 0.6 / k.fy);
        if (cloud.normals[i].isZero()) continue;
        ++with_normal;
        const Vector3d p_world = camera * p.cast<double>(), n_world = camera.R * cloud.normals[i].cast<double>();
        double distance = 1e9, cosine = 0;
        for (const auto& plane : scene) {
          const double d = std::abs(plane.n.dot(p_world) - plane.h);
          if (d < distance) distance = d, cosine = -plane.n.dot(n_world);  // towards the camera: into the room
        }
        off_plane += distance > 0.002;
        off_normal += cosine < 0.9998;  // about 1 degree
        EXPECT_NEAR(n_world.norm(), 1, 1e-5);
        EXPECT_LT(cloud.normals[i].dot(p), 0);
      }
    }
    EXPECT_GT(with_normal, width * width * 3 / 4 * 8 / 10);
    EXPECT_LT(off_plane, with_normal / 20);  // the cells on edges
    EXPECT_LT(off_normal, with_normal / 6);  // the windows across edges
  }
}

TEST(PointCloud, NoNormalAcrossADepthStepAndNoneWithoutDepth) {
  const hal::Intrinsics k;
  std::vector<std::uint16_t> depth(640 * 480, 5000);
  for (int v = 0; v < 480; ++v) {
    for (int u = 320; u < 640; ++u) depth[static_cast<std::size_t>(v * 640 + u)] = u < 480 ? 10000 : 0;
  }
  OrganizedCloud cloud;
  organize(depth, k, 160, 120, cloud);
  for (int u = 0; u < 120; ++u) {
    const Vector3f& n = cloud.normals[static_cast<std::size_t>(60 * 160 + u)];
    if (!n.isZero()) {
      EXPECT_LT(n.z(), -0.999f) << u;
    }
  }
  for (int u = 121; u < 160; ++u) {
    EXPECT_EQ(cloud.points[static_cast<std::size_t>(60 * 160 + u)].z(), 0);
    EXPECT_TRUE(cloud.normals[static_cast<std::size_t>(60 * 160 + u)].isZero());
  }
}

TEST(PointCloud, SecondImageReusesTheMemory) {
  const hal::Intrinsics k = kinect();
  std::vector<std::uint16_t> depth(640 * 480, 5000), other(640 * 480, 9000);
  OrganizedCloud cloud, fresh;
  organize(other, k, 160, 120, cloud);
  const auto* points = cloud.points.data();
  organize(depth, k, 160, 120, cloud);
  organize(depth, k, 160, 120, fresh);
  EXPECT_EQ(cloud.points.data(), points);
  EXPECT_EQ(cloud.points, fresh.points);
  EXPECT_EQ(cloud.normals, fresh.normals);
}

}  // namespace
}  // namespace onemap::mapping
