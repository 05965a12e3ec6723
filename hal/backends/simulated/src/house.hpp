#pragma once
#include "scene.hpp"

namespace onemap::hal::simulated {

// A bright house of three open rooms in a row, 10.5 x 4.6 m: living room (west), kitchen, bedroom (east). Half-walls
// part them on the south side; a bookshelf stands on the north wall at each passage.
void house(SceneBuilder& b);

// The way of a robot through its room of the house (rooms are dealt out in turn, from the west): a round of 18 s, eyes
// all around and from floor to ceiling, with the shelf at each passage in view once: there it sees what its neighbour
// sees.
CameraPose pose_in_house(int robot, std::uint64_t seed, double time_s);

}  // namespace onemap::hal::simulated
