#pragma once
#include "landmark_map.hpp"
#include "mapping/local/organized_cloud.hpp"
#include "mapping/records/keyframe.hpp"

namespace onemap::mapping {

// The organised depth of a keyframe in units of 0.25 mm, and back as a cloud with normals.
void store_grid(const OrganizedCloud& cloud, MapKeyframe& keyframe);
void grid_cloud(const MapKeyframe& keyframe, OrganizedCloud& out);

// What leaves the robot of a sealed keyframe: the grid, and the features that have a depth and a place on it, by bits.
void fill_record(const MapKeyframe& keyframe, KeyframeRecord& out);

}  // namespace onemap::mapping
