#pragma once
#include "mapping/team/pose_graph_config.hpp"
#include "mapping/team/pose_graph_input.hpp"

namespace onemap::mapping {

// A relative pose between two anchors, given by their place in somebody's list.
struct GraphEdge {
  std::size_t a = 0, b = 0;
  Pose T_a_b;
  Matrix6d information = Matrix6d::Identity();  // of motion_error(T_a_b^-1 X_a^-1 X_b), so in the frame of b
};

// A link moved from its keyframes to their anchors; a and b stay 0.
GraphEdge edge_of(const GraphLink& link, const LinkNoise& noise);

struct Linearised {
  Vector6d error = Vector6d::Zero();
  Matrix6d J_a, J_b;  // by small motions X_a D(d_a), X_b D(d_b)
};
Linearised linearise(const GraphEdge& edge, const Pose& X_a, const Pose& X_b);

// In sigmas: chi square of 6 degrees of freedom when the edge is right.
double squared_error(const GraphEdge& edge, const Pose& X_a, const Pose& X_b);

}  // namespace onemap::mapping
