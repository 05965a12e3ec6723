#pragma once
#include "mapping/team/team_map.hpp"
#include "render/figures.hpp"

namespace onemap::daemon {

// The team as this robot knows it: who is in it, and each pair's last verification, with the reason where it was
// refused.
render::TeamPicture team_picture(const mapping::TeamMap& team);

}  // namespace onemap::daemon
