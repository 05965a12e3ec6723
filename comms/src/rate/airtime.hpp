#pragma once
#include <algorithm>
#include <cstddef>

namespace onemap::comms {

// Whose turn it is, when several neighbours wait for data: each gets an equal share of the time on air, so a neighbour
// far away, to whom a byte takes long, does not slow the others. (Start-time fair queueing: Goyal, Vin, Cheng 1996,
// with time as the cost.) Who had nothing to send is owed nothing.
class AirtimeTurn {
 public:
  double start(double virtual_time) const { return std::max(used_, virtual_time); }
  // Answers the new virtual time.
  double sent(double virtual_time, std::size_t bytes, double bytes_per_second) {
    const double began = start(virtual_time);
    used_ = began + static_cast<double>(bytes) / bytes_per_second;
    return began;
  }

 private:
  double used_ = 0.0;  // seconds
};

}  // namespace onemap::comms
