#pragma once
#include "options.hpp"
#include "scene.hpp"

namespace onemap::hal::simulated {

// The whole scene of a name and a seed.
Scene build_scene(SceneName name, std::uint64_t seed);

// The team's way through it, chosen so that nothing stands in it whatever the seed.
Walk walk_in(SceneName name, std::uint64_t seed);

}  // namespace onemap::hal::simulated
