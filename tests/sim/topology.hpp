#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "support/random.hpp"

// Who can hear whom: graphs of robots that are numbered from 0.
namespace onemap::comms::sim {

using test::Random;
using Edge = std::pair<std::size_t, std::size_t>;

std::vector<Edge> line(std::size_t n);
std::vector<Edge> ring(std::size_t n);
std::vector<Edge> star(std::size_t n);
std::vector<Edge> complete(std::size_t n);
// A random tree, and so many edges beside it (some of which may be there already).
std::vector<Edge> connected(std::size_t n, std::size_t more, Random& random);

// Links on a shortest way from one robot to each; -1: there is none.
std::vector<int> distances(std::size_t n, const std::vector<Edge>& edges, std::size_t from);

}  // namespace onemap::comms::sim
