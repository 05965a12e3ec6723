#pragma once
#include <cstdint>

#include "sim/sim_net.hpp"

namespace onemap::comms::sim {

// A large team at its daily work: each robot hears some others and tells again and again where it is, over links that
// lose one datagram of a hundred. Nothing goes wrong.
struct Exploring {
  std::size_t robots = 100, degree = 10;  // the mean of how many each hears
  Duration every = std::chrono::seconds(10);
  Duration lasts = std::chrono::seconds(30);
};
struct Explored {
  bool equal = false;   // within ten seconds after the last record
  Duration to_equal{};  // so long after it
  Duration simulated{};
  double real_s = 0;
  std::uint64_t records = 0, datagrams = 0, bytes = 0;
};
Explored explore(const Exploring& team, std::uint64_t seed);

}  // namespace onemap::comms::sim
