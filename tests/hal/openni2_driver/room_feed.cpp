#include "room_feed.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/backends/simulated.hpp"

namespace onemap::test {

RoomFeed::RoomFeed(const DeviceFile& device) {
  auto address = hal::parse_camera_address(device.room);
  if (!address) throw std::runtime_error(address.error().text());
  auto camera = hal::open_simulated(*address);
  if (!camera) throw std::runtime_error(camera.error().text());
  camera_ = std::move(*camera);
  pool_ = std::make_unique<hal::FramePool>(camera_->intrinsics(), 1);
  frame_ = pool_->acquire();
}

bool RoomFeed::next() {
  if (camera_->grab(frame_, {}) != hal::Grab::frame) return false;
  const FrameTime now = frame_.colour_time;
  if (frame_.index == 0) first_ = now;
  time_ = std::chrono::round<std::chrono::microseconds>(now - first_);
  return true;
}

// Every point of the colour camera's picture into the depth camera's; the nearest wins. A point covers what four
// pixels of the finer picture may need, so that surfaces have no gaps.
void RoomFeed::look_from_the_left() {
  const hal::Intrinsics& k = colour();
  left_.assign(frame_.depth().size(), 0);
  for (int y = 0; y < k.height; ++y) {
    for (int x = 0; x < k.width; ++x) {
      const std::uint16_t value = frame_.depth()[static_cast<std::size_t>(y * k.width + x)];
      if (value == 0) continue;
      const double z = value / k.depth_scale;
      const double u = depth_focal_px() * ((x - k.cx) / k.fx + kBaseline_m / z) + k.cx;
      const double v = depth_focal_px() * (y - k.cy) / k.fy + k.cy;
      for (const double du : {-0.3, 0.3}) {
        for (const double dv : {-0.3, 0.3}) {
          const auto column = std::lround(u + du), row = std::lround(v + dv);
          if (column < 0 || row < 0 || column >= k.width || row >= k.height) continue;
          std::uint16_t& there = left_[static_cast<std::size_t>(row * k.width + column)];
          there = there == 0 ? value : std::min(there, value);
        }
      }
    }
  }
}

std::span<const std::uint16_t> RoomFeed::depth(bool hundred_um, bool registered) {
  if (!registered) look_from_the_left();
  const std::span<const std::uint16_t> from = registered ? frame_.depth() : std::span<std::uint16_t>(left_);
  const double units = (hundred_um ? 10000 : 1000) / colour().depth_scale;
  out_.resize(from.size());
  std::ranges::transform(from, out_.begin(), [&](std::uint16_t value) {
    const auto scaled = std::lround(value * units);
    return scaled > 65535 ? std::uint16_t{0} : static_cast<std::uint16_t>(scaled);
  });
  return out_;
}

}  // namespace onemap::test
