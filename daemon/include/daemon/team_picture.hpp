#pragma once
#include <vector>

#include "daemon/report.hpp"
#include "mapping/team/team_map.hpp"
#include "render/figures.hpp"

namespace onemap::daemon {

// The team as this robot knows it: who is in it, and what joins them or does not (merges_of() the team).
render::TeamPicture team_picture(const mapping::TeamMap& team, const std::vector<Merge>& merges);

}  // namespace onemap::daemon
