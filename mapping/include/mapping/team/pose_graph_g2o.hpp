#pragma once
#include <string>

#include "mapping/team/pose_graph.hpp"

namespace onemap::mapping {

// The graph's first component as g2o text: VERTEX_SE3:QUAT with the solved poses, FIX of the reference, EDGE_SE3:QUAT
// of odometry and of the links in use. Vertex ids are chain number << 20 | keyframe of the anchor, chains numbered in
// their order (comment lines say which is which). Information is for g2o's rotation error, which is half the angle:
// the rotation block is that of radians times 4, the cross blocks times 2; a comment line says so. Vertices and edges
// sorted, numbers as short as they read back: equal graphs give equal bytes.
std::string to_g2o(const PoseGraph& graph, const GraphSolution& solution);

}  // namespace onemap::mapping
