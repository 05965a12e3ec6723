#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/focal_check.hpp"

namespace onemap::daemon {

// What a depth image looks like from afar.
struct DepthLook {
  double valid = 0;                            // share of pixels with a reading, 0 to 1
  double near_m = 0, median_m = 0, far_m = 0;  // 5th, 50th, 95th percentile of the readings
  double step_m = 0;                           // the finest difference between readings; 0: all are equal
  double brightness = 0;                       // mean of the colour image, 0 to 1
};

// Looks at one pixel of each block of 8 x 8. scratch is used again.
DepthLook look_at(const hal::FrameView& frame, std::vector<std::uint16_t>& scratch);

// What is not as a depth camera indoors has it, in words with what to do; empty: nothing. A wrong scale cannot be seen
// from the images alone, only that its result is no room.
std::vector<std::string> doubts(const DepthLook& look);
std::vector<std::string> doubts(const hal::Intrinsics& intrinsics);

// Of a focal length that is wrong(), what it looks like from what was seen.
std::string doubt(const mapping::FocalEstimate& focal);
inline constexpr const char* kCalibrate = "give the camera's own calibration in its address";

}  // namespace onemap::daemon
