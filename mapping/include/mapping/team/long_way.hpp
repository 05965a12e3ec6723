#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/records/trajectory.hpp"

namespace onemap::mapping {

// The poses of a way that may have no end, in bounded memory: when there are too many, of all every second one is kept,
// then every fourth, ... Each is held as what it differs by from going on evenly, some 20 bytes of 36; nothing is lost.
class LongWay {
 public:
  explicit LongWay(std::size_t most) : most_(most) {}

  void add(const StampedPose& pose);
  std::vector<StampedPose> poses() const;
  std::size_t size() const { return packed_.size; }
  std::size_t bytes() const { return packed_.bytes.size(); }  // that they take
  std::uint64_t added() const { return added_; }
  std::uint64_t each() const { return each_; }  // of so many one is kept

 private:
  using Fields = std::array<std::uint64_t, 8>;  // time, position, rotation, modulo 2^64
  struct Packed {
    std::vector<std::uint8_t> bytes;
    std::size_t size = 0;
    Fields last{}, before{};
    void push(const StampedPose& pose);
  };
  void thin();

  std::size_t most_;
  Packed packed_;
  std::uint64_t added_ = 0, each_ = 1;
};

}  // namespace onemap::mapping
