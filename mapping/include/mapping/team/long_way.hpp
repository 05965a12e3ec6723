#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/records/trajectory.hpp"

namespace onemap::mapping {

// The poses of a way that may have no end, in bounded memory: when there are too many, of all every second one is kept,
// then every fourth, ...
class LongWay {
 public:
  explicit LongWay(std::size_t most) : most_(most) {}

  void add(const StampedPose& pose) {
    if (added_++ % each_ != 0) return;
    if (poses_.size() >= most_) thin();
    if ((added_ - 1) % each_ == 0) poses_.push_back(pose);
  }
  const std::vector<StampedPose>& poses() const { return poses_; }
  std::uint64_t added() const { return added_; }
  std::uint64_t each() const { return each_; }  // of so many one is kept

 private:
  void thin() {
    const std::size_t kept = (poses_.size() + 1) / 2;
    for (std::size_t i = 1; i < kept; ++i) poses_[i] = poses_[2 * i];
    poses_.resize(kept);
    each_ *= 2;
  }

  std::size_t most_;
  std::vector<StampedPose> poses_;
  std::uint64_t added_ = 0, each_ = 1;
};

}  // namespace onemap::mapping
