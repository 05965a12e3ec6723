#pragma once
#include <cstdint>
#include <deque>
#include <vector>

#include "mapping/records/keyframe.hpp"

namespace onemap::mapping {

// The keyframes of a robot that is alone, for its floor plan: as records without features, compressed quickly, within a
// budget of bytes. When it is full, every second one goes, and from then on only so many are taken: the way is
// covered less densely, but all of it. Used by one thread.
class KeptKeyframes {
 public:
  struct Kept {
    std::uint32_t index = 0;
    QuantizedPose T_robot_keyframe;
    std::vector<std::uint8_t> body;  // of a KeyframeRecord
  };

  explicit KeptKeyframes(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}
  void add(const KeyframeRecord& record);

  const std::deque<Kept>& all() const { return kept_; }  // in the order in which they came
  std::size_t bytes() const { return bytes_; }
  std::uint64_t left_out() const { return left_out_; }  // for want of room

 private:
  void thin_out();

  const std::size_t budget_bytes_;
  std::deque<Kept> kept_;
  std::size_t bytes_ = 0;
  std::uint64_t left_out_ = 0;
  std::uint32_t step_ = 1;  // only keyframes whose index is a multiple are kept
};

}  // namespace onemap::mapping
