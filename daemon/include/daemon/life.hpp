#pragma once
#include <cstdint>
#include <string>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// The number of this robot's lives, its incarnation: kept in FOLDER/life, so that a clock that went back between two
// starts does not make the new life look older than the last one. Nanoseconds since 1970 are only the smallest that a
// new life may have, for a robot whose file is gone.
class LifeCounter {
 public:
  explicit LifeCounter(const std::string& folder) : file_(folder + "/life") {}

  // A greater number than every one before, written before it is returned. The error (a file that cannot be written or
  // whose text is no number) comes with a number that is as good as the clock: see number().
  Status begin(std::uint64_t wall_clock_ns);
  // Neighbours know of a greater one: the next number is above that, and kept as well.
  Status begin_after(std::uint64_t outlived);
  std::uint64_t number() const { return number_; }

 private:
  Status keep(std::uint64_t number);
  const std::string file_;
  std::uint64_t number_ = 0;
};

}  // namespace onemap::daemon
