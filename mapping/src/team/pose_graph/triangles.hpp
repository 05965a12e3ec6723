#pragma once
#include "joining.hpp"

namespace onemap::mapping {

// A look-alike group passes every test among its own links; third chains can tell. Of each three chains that joined
// pairs connect, the ring of their best links closes or not. A pair is for itself, with its links that agree and, of
// each ring that closes, those of the weaker other pair; against it is the same of rings that do not close. Pairs with
// more against them than the second group's share are withdrawn: the worst alone where it is beyond doubt, else with
// all others of its rings that are in doubt. Time grows with the cube of the chains.
void doubt_triangles(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config,
                     std::vector<ChainPair>& pairs);

}  // namespace onemap::mapping
