#pragma once
#include <gtest/gtest.h>

#include <vector>

#include "mapping/team/pose_graph.hpp"

// Chains that are straight lines, and links between them, by hand.
namespace onemap::mapping::test_lines {

inline ChainId chain_id(const char* name) { return {RobotId::from_name(name), 1}; }

// Anchors a metre apart on a straight line, as odometry has them.
inline std::vector<ChainAnchor> line(std::uint32_t count) {
  std::vector<ChainAnchor> out;
  for (std::uint32_t i = 0; i < count; ++i) {
    ChainAnchor anchor;
    anchor.keyframe = i;
    anchor.information = information_of(0.003, 0.01);
    anchor.box_half_m = {1, 1, 1};
    if (i > 0) anchor.T_previous_anchor.t = {1, 0, 0};
    out.push_back(anchor);
  }
  return out;
}

inline GraphLink link(const char* a, std::uint32_t i, const char* b, std::uint32_t j, const Pose& T_a_b) {
  GraphLink out;
  out.a = {.chain = chain_id(a), .keyframe = i, .anchor = i, .T_anchor_keyframe = {}};
  out.b = {.chain = chain_id(b), .keyframe = j, .anchor = j, .T_anchor_keyframe = {}};
  out.T_a_b = T_a_b;
  return out;
}

inline Pose shift(double x, double y = 0, double z = 0) { return {Matrix3d::Identity(), {x, y, z}}; }

// Two lines beside each other, linked straight across in so many places.
inline PoseGraph two_lines(std::uint32_t places, const PoseGraphConfig& config = {}) {
  PoseGraph graph(config);
  EXPECT_TRUE(graph.set_chain(chain_id("a"), line(20)));
  EXPECT_TRUE(graph.set_chain(chain_id("b"), line(20)));
  for (std::uint32_t i = 0; i < places; ++i) EXPECT_TRUE(graph.set_link(link("a", 2 * i, "b", 2 * i, shift(0, 3))));
  return graph;
}

}  // namespace onemap::mapping::test_lines
