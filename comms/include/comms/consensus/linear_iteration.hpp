#pragma once
#include <cstddef>
#include <span>

// The consensus of Ayuso, Sagüés, Aragüés (2013), section 2: robots that only talk to their neighbours come to agree on
// the mean of what they began with.
namespace onemap::comms {

// w_ij of equation (2) after Xiao, Boyd and Lall (2005). Symmetric, so what one robot gives the other takes; and a
// robot's weights of its neighbours sum to less than 1.
double metropolis_weight(std::size_t own_neighbours, std::size_t other_neighbours);

// What a neighbour said: its value, and how many neighbours it has itself.
struct NeighbourValue {
  double value = 0.0;
  std::size_t neighbours = 0;
};
// One step of equation (2) at one robot: x_i(t+1) from x_i(t) and those of its neighbours. All robots that take it
// together take equation (3). It reaches the mean (4) only while no message is lost: a lost one takes value away, and
// the robots agree on something else (tests/comms/consensus_test.cpp). RunningSums loses nothing.
double linear_iteration(double own, std::span<const NeighbourValue> neighbours);

}  // namespace onemap::comms
