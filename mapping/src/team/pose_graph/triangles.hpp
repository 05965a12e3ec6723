#pragma once
#include "joining.hpp"

namespace onemap::mapping {

// A look-alike group passes every test among its own links; third chains can tell. Of each three chains that pairs with
// links that agree connect, the ring of their best links closes or not. For a pair speak its links that agree and, of
// each ring that closes, those of the weaker other pair; against it the second group of its own links, and the same of
// rings that do not close. Of rings with a pair that may not join, because its links are not from where they should all
// be, only the loudest speaks. The worst that has more against it than the second group's share is withdrawn, with all
// others of its rings that are in doubt like that; and so on. Time grows with the cube of the chains.
void doubt_triangles(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config,
                     std::vector<ChainPair>& pairs);

}  // namespace onemap::mapping
