#pragma once
#include "mapping/local/local_mapper.hpp"
#include "mapping/team/atlas.hpp"

namespace onemap::mapping {

// One robot's own map, in its own frame: the submaps that its mapper knows, each where the mapper has its anchor. For
// pictures and models, not for the frame path. config.map: its budget and the mapper's voxel size.
Atlas local_atlas(const LocalMapper& mapper, const AtlasConfig& config);

}  // namespace onemap::mapping
