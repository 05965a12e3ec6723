#include "comms/consensus/linear_iteration.hpp"

#include <algorithm>

namespace onemap::comms {

double metropolis_weight(std::size_t own_neighbours, std::size_t other_neighbours) {
  return 1.0 / (1.0 + static_cast<double>(std::max(own_neighbours, other_neighbours)));
}

double linear_iteration(double own, std::span<const NeighbourValue> neighbours) {
  double next = own;  // w_ii = 1 - sum of the others
  for (const NeighbourValue& other : neighbours)
    next += metropolis_weight(neighbours.size(), other.neighbours) * (other.value - own);
  return next;
}

}  // namespace onemap::comms
