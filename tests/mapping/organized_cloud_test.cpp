#include "mapping/local/organized_cloud.hpp"

#include <gtest/gtest.h>

#include "support/box_room.hpp"
#include "support/kinect_lens.hpp"

namespace onemap::mapping {
namespace {

TEST(OrganizedCloud, PlanesHaveTheirPointsAndNormals) {
  const hal::Intrinsics k = test::kinect_lens();
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

TEST(OrganizedCloud, NoNormalAcrossADepthStepAndNoneWithoutDepth) {
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

TEST(OrganizedCloud, SecondImageReusesTheMemory) {
  const hal::Intrinsics k = test::kinect_lens();
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
