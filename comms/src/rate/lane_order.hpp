#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/base/record.hpp"

namespace onemap::comms {

// Which lane is served next to one neighbour: the lowest that waits, but a lane that has a floor gets at least that
// share of the bytes while it waits.
class LaneOrder {
 public:
  static constexpr std::array<double, kLaneCount> kFloor{0.05, 0.0, 0.0, 0.10, 0.0};  // control, voxels
  static constexpr double kDue = 1200, kMost = 4 * 1200;                              // bytes
  // `waits(lane)`; kLaneCount when nothing waits.
  template <class Waits>
  std::uint8_t next(Waits waits) const {
    std::uint8_t lowest = kLaneCount;
    for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) {
      if (!waits(lane)) continue;
      lowest = std::min(lowest, lane);
      if (owed_[lane] >= kDue) return lane;
    }
    return lowest;
  }
  // So many bytes of this lane went out; `waits` as it was then. Nobody is owed for when it had nothing to send.
  template <class Waits>
  void sent(std::uint8_t lane, std::size_t bytes, Waits waits) {
    for (std::uint8_t other = 0; other < kLaneCount; ++other)
      owed_[other] = waits(other) ? std::min(owed_[other] + kFloor[other] * static_cast<double>(bytes), kMost) : 0.0;
    owed_[lane] = std::max(0.0, owed_[lane] - static_cast<double>(bytes));
  }

 private:
  std::array<double, kLaneCount> owed_{};
};

}  // namespace onemap::comms
