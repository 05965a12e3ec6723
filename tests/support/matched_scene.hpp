#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "support/poses.hpp"

namespace onemap::test {

// Points of a scene 0.7 - 4 m in front of both cameras, r = T s, with pixel and depth noise and outliers.
struct MatchedScene {
  mapping::Pose T_r_s;
  std::vector<mapping::Vector3d> r3, s3;
  std::vector<Eigen::Vector2d> r2, s2;
  std::vector<bool> good;
};

inline MatchedScene make_matched_scene(std::size_t n, double outliers, std::uint64_t seed, bool noise = true) {
  Random random(seed);
  MatchedScene scene;
  scene.T_r_s = random_pose(random, 0.15, 0.2);
  const auto measure = [&](const mapping::Vector3d& p) {
    const double pixel = noise ? 0.5 / 525 : 0, z = p.z();
    const double measured = z + (noise ? random.normal(0.0012 + 0.0019 * (z - 0.4) * (z - 0.4)) : 0);
    return mapping::Vector3d((p.x() / z + random.normal(pixel)) * measured,
                             (p.y() / z + random.normal(pixel)) * measured, measured);
  };
  const auto any = [&] {
    const double z = random.uniform(0.9, 4);
    return mapping::Vector3d(random.uniform(-0.5, 0.5) * z, random.uniform(-0.4, 0.4) * z, z);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const mapping::Vector3d s = any();
    const bool good = random.uniform(0, 1) >= outliers;
    scene.good.push_back(good);
    scene.s3.push_back(measure(s));
    scene.r3.push_back(good ? measure(scene.T_r_s * s) : any());
    scene.r2.emplace_back(scene.r3.back().head<2>() / scene.r3.back().z());
    scene.s2.emplace_back(scene.s3.back().head<2>() / scene.s3.back().z());
  }
  return scene;
}

inline std::pair<int, int> right_and_wrong(const MatchedScene& scene, const std::vector<std::uint8_t>& inlier) {
  int right = 0, wrong = 0;
  for (std::size_t i = 0; i < inlier.size(); ++i) (scene.good[i] ? right : wrong) += inlier[i];
  return {right, wrong};
}

}  // namespace onemap::test
