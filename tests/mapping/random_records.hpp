#pragma once
#include "mapping/records/finished.hpp"
#include "mapping/records/frontier.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/ruling.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"
#include "support/random.hpp"

// A record of each kind with whatever it may hold.
namespace onemap::mapping::random_records {

using test::Random;

inline QuantizedPose random_pose(Random& random) {
  Vector6d motion;
  for (int i = 0; i < 6; ++i) motion[i] = random.uniform(-2, 2);
  return quantize(small_motion(motion));
}

inline HelloRecord random_hello(Random& random) {
  return {"robot" + std::to_string(random.integer(1, 99)),
          std::string(static_cast<std::size_t>(random.integer(0, 200)), 'c'), random.next(),
          static_cast<std::uint32_t>(random.integer(0, 1 << 24))};
}

inline KeyframeRecord random_keyframe(Random& random) {
  KeyframeRecord out;
  out.index = static_cast<std::uint32_t>(random.next());
  out.time = frame_time_from_ns(static_cast<std::int64_t>(random.next() >> 2));
  out.T_robot_keyframe = random_pose(random);
  const bool orb = random.integer(0, 1) == 1;
  out.descriptor_kind = orb ? DescriptorKind::orb : DescriptorKind::surf_bits;
  out.features.resize(static_cast<std::size_t>(random.integer(0, 20)));
  for (auto& f : out.features) {
    const auto part = [&](int least) { return static_cast<std::uint16_t>(random.integer(least, FeaturePlace::kMost)); };
    f.place = {part(0), part(0), part(1)};
    f.laplacian = static_cast<std::int8_t>(orb ? 0 : 2 * random.integer(0, 1) - 1);
    for (auto& word : f.bits) word = random.next();
  }
  out.grid.fx_fy_cx_cy = {1 << 17, 1 << 17, -5, 7};
  if (random.integer(0, 3) > 0) {
    out.grid.width = static_cast<std::uint16_t>(random.integer(1, 12));
    out.grid.height = static_cast<std::uint16_t>(random.integer(1, 9));
    for (int i = 0; i < out.grid.width * out.grid.height; ++i)
      out.grid.inverse_depth.push_back(static_cast<std::uint16_t>(
          random.integer(0, 3) == 0 ? 0 : random.integer(DepthGrid::kFarthest, DepthGrid::kNearest)));
  }
  return out;
}

inline TrajectoryRecord random_trajectory(Random& random) {
  TrajectoryRecord out;
  std::int64_t ns = 0;
  for (auto n = random.integer(0, 20); n > 0; --n)
    out.poses.push_back({frame_time_from_ns(ns += random.integer(1, 1 << 30)), random_pose(random)});
  return out;
}

inline SubmapRecord random_submap(Random& random) {
  SubmapRecord out{static_cast<std::uint32_t>(random.next()), 20000, 60000, {}};
  std::int32_t x = -7;
  for (auto n = random.integer(0, 5); n > 0; --n) {
    SubmapBlock block;
    block.key = {x += static_cast<std::int32_t>(random.integer(1, 3)), static_cast<std::int32_t>(random.integer(-9, 9)),
                 4};
    for (auto& voxel : block.voxels) {
      if (random.integer(0, 2) == 0) continue;
      voxel.tsdf = static_cast<std::int16_t>(random.integer(-kTsdfOne, kTsdfOne));
      voxel.weight = static_cast<std::uint8_t>(random.integer(1, 255));
      if (random.integer(0, 1) == 0) continue;
      voxel.rgb = {static_cast<std::uint8_t>(random.integer(0, 255)), static_cast<std::uint8_t>(random.integer(0, 255)),
                   1};
    }
    out.blocks.push_back(block);
  }
  return out;
}

inline LinkRecord random_link(Random& random) {
  LinkRecord out;
  out.a = RobotId::from_name("robot1");
  out.b = RobotId::from_name("robot" + std::to_string(random.integer(2, 9)));
  out.incarnation_other = random.next();
  out.keyframes_a = static_cast<std::uint32_t>(random.next());
  out.keyframes_b = static_cast<std::uint32_t>(random.next());
  out.reason = static_cast<LinkReason>(random.integer(0, 10));
  if (out.reason != LinkReason::accepted) out.measured = static_cast<std::uint32_t>(random.next());
  out.supporting_pairs = static_cast<std::uint32_t>(random.integer(1, 32));
  out.inliers = static_cast<std::uint32_t>(random.integer(0, 1000));
  out.ratio_e4 = static_cast<std::uint32_t>(random.integer(0, 10000));
  out.error_um = static_cast<std::int32_t>(random.integer(0, 1 << 30));
  out.T_a_b = random_pose(random);
  if (out.reason != LinkReason::accepted) return out;
  for (auto n = random.integer(0, 3); n > 0; --n)
    out.pairs.push_back({static_cast<std::uint32_t>(9 - n), static_cast<std::uint32_t>(random.integer(0, 99)),
                         static_cast<std::uint32_t>(random.integer(1, 1000)), random_pose(random)});
  return out;
}

inline SolutionRecord random_solution(Random& random) {
  SolutionRecord out;
  const auto n = random.integer(1, 9);
  for (int i = 1; i <= n; ++i) {
    SolvedRobot& solved = out.robots.emplace_back();
    solved.chain = {RobotId::from_name("robot" + std::to_string(i)), random.next()};
    for (std::uint32_t anchor = 0; anchor < 5; ++anchor)
      if (random.integer(0, 1) == 0) solved.anchors.push_back({anchor, random_pose(random)});
  }
  out.reference = out.robots[static_cast<std::size_t>(random.integer(0, n - 1))].chain;
  out.links_used = static_cast<std::uint32_t>(random.next());
  out.links_refused = static_cast<std::uint32_t>(random.next());
  out.map.voxel_um = static_cast<std::int32_t>(random.integer(1000, 1'000'000));
  out.map.truncation_um = static_cast<std::int32_t>(random.integer(1, 100)) * out.map.voxel_um;
  out.map.blocks = static_cast<std::uint32_t>(random.integer(1, 1 << 24));
  out.up = up_direction(Vector3f(1, -2, 2) / 3);
  return out;
}

inline RulingRecord random_ruling(Random& random) {
  const ChainId a{RobotId::from_name("a"), random.next()}, b{RobotId::from_name("b"), random.next()};
  return {a, b, random.integer(0, 1) == 1, static_cast<std::uint32_t>(random.integer(1, 1 << 30))};
}

inline FrontierRecord random_frontier(Random& random) {
  FrontierRecord out;
  out.solution = random.next();
  for (auto n = random.integer(0, 9); n > 0; --n)
    out.chains.push_back({{RobotId::from_name("robot" + std::to_string(9 - n)), random.next()},
                          static_cast<std::uint32_t>(random.next()),
                          static_cast<std::uint32_t>(random.next())});
  return out;
}

inline FinishedRecord random_finished(Random& random) {
  const auto frames = static_cast<std::uint32_t>(random.integer(0, 1 << 20));
  return {frames, frames / 2, 7, static_cast<std::uint32_t>(random.next())};
}

// A kind's codec, for the tests that every kind must pass.

}  // namespace onemap::mapping::random_records
