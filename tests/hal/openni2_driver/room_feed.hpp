#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "device_file.hpp"
#include "hal/depth_camera.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::test {

// Where the device's depth camera is: this much to the left of the colour camera, looking the same way.
constexpr double kBaseline_m = 0.025;
constexpr double kDepthFocalAt640 = 570.3;

// What a device sees, picture after picture; it outlives the device's being pulled out.
class RoomFeed {
 public:
  explicit RoomFeed(const DeviceFile& device);
  const hal::Intrinsics& colour() const { return camera_->intrinsics(); }
  double depth_focal_px() const { return kDepthFocalAt640 * colour().width / 640; }
  bool next();  // false: the room's walk is over
  std::uint64_t index() const { return frame_.index; }
  std::chrono::microseconds time() const { return time_; }  // since the first picture
  std::span<const std::uint8_t> rgb() const { return frame_.rgb(); }
  // In mm or 100 um, as seen by the colour camera or by the depth camera. Valid until the next call.
  std::span<const std::uint16_t> depth(bool hundred_um, bool registered);

 private:
  void look_from_the_left();
  std::unique_ptr<hal::DepthCamera> camera_;
  std::unique_ptr<hal::FramePool> pool_;
  hal::Frame frame_;
  FrameTime first_{};
  std::chrono::microseconds time_{};
  std::vector<std::uint16_t> left_, out_;
};

}  // namespace onemap::test
