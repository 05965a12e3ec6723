#pragma once
#include <array>
#include <cstdint>
#include <numeric>

#include "comms/counters.hpp"
#include "hal/base/record.hpp"

namespace onemap::comms {

// Every byte that went between this robot and one neighbour, by what it was: UDP payload, as it was on the network.
struct Traffic {
  struct Way {
    // By FrameType's index_of, frame heads included. Index 0: headers and seals of datagrams, and frames that this
    // version does not know. DATA is in `data`.
    std::array<std::uint64_t, kFrameTypeCount> frames{};
    std::array<std::uint64_t, kLaneCount> data{};  // DATA frames by lane
    std::uint64_t total() const {
      return std::accumulate(data.begin(), data.end(), std::accumulate(frames.begin(), frames.end(), std::uint64_t{0}));
    }
    bool operator==(const Way&) const = default;
  };
  Way in, out;
};

}  // namespace onemap::comms
