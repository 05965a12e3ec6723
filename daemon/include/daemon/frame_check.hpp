#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "hal/frame.hpp"

namespace onemap::daemon {

enum class FrameFault { frozen, black, saturated, no_depth };
constexpr std::size_t kFrameFaults = 4;

// Looks at some pixels of each frame for what no camera that works shows: the very same pixels again and again (a real
// sensor has noise), only black, only white, no depth at all. Pure; takes microseconds.
class FrameCheck {
 public:
  static constexpr std::uint64_t kPatience = 10;  // frames in a row before something is said

  struct Seen {
    std::array<bool, kFrameFaults> faults{};
    // Lines for people, each about a fault that lasts since kPatience frames, or that ended then.
    std::string began, ended;
    bool frozen = false;  // for so long that what it shows is not where the robot is
  };
  Seen look(const hal::FrameView& frame);
  std::uint64_t frames(FrameFault fault) const { return runs_[static_cast<std::size_t>(fault)].frames; }

 private:
  struct Run {
    std::uint64_t frames = 0, in_a_row = 0;  // that had it
  };
  std::array<bool, kFrameFaults> faults_of(const hal::FrameView& frame);
  std::array<Run, kFrameFaults> runs_;
  std::uint64_t last_pixels_ = 0;
  bool any_ = false;  // a frame was seen
};

}  // namespace onemap::daemon
