#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/saved_map.hpp"
#include "mapping/team/map_fusion.hpp"
#include "mapping/team/survey.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::daemon {

// What pictures, models and floor plans are made of: everybody's records, and the global map where there is one.
struct MapSource {
  const mapping::TeamLog& log;
  const mapping::SolutionRecord* solution = nullptr;  // with the map, or neither
  const mapping::VoxelMap* map = nullptr;
};

// The team's map as this robot can hold it.
mapping::AtlasConfig global_map(const Config& config);

// The floor plan of the global map, and without one of this robot's own odometry.
Result<mapping::Survey> survey_of(
    const MapSource& from, const mapping::SurveyConfig& config,
    const std::function<bool()>& stop = [] { return false; });

// The same written as STEM.pgm and STEM.yaml while the robot works: of few keyframes, so that it takes at most a second
// or two. It needs no voxels. False, and nothing is written: no floor is seen (a desk is no failure), or stop() said
// true.
Result<bool> write_plan(const MapSource& from, mapping::SurveyConfig config, const std::vector<std::string>& stems,
                        const std::function<bool()>& stop);

// The team's map and everybody's way in it, saved; there must be one. title: for the picture.
std::vector<std::uint8_t> save_global(const MapSource& from, const std::string& title);

// This robot's own records where its odometry has them, saved: what it would hold without its team. They are fused
// anew, which takes as long as they are many. Nothing when the log has none of them, or stop() said true.
std::optional<std::vector<std::uint8_t>> save_local(
    const MapSource& from, const Config& config, const std::string& title,
    const std::function<bool()>& stop = [] { return false; });

}  // namespace onemap::daemon
