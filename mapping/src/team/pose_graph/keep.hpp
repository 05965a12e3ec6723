#pragma once
#include "mapping/team/pose_graph_input.hpp"

namespace onemap::mapping {

// Whether a corner of the anchor's box is at least so far from where the pose in use has it. The pose in use, not the
// last one that was computed: many small bends must not creep by unseen.
bool box_moved(const ChainAnchor& anchor, const Pose& in_use, const Pose& now, double bound_m);

}  // namespace onemap::mapping
