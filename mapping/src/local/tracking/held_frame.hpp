#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "hal/frame.hpp"

namespace onemap::mapping {

// A frame that waits for the next one. Memory is taken in the constructor.
class HeldFrame {
 public:
  explicit HeldFrame(const hal::Intrinsics& k) : intrinsics_(k) {
    const std::size_t pixels = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
    rgb_.resize(3 * pixels);
    depth_.resize(pixels);
  }
  bool any() const { return any_; }
  void hold(const hal::FrameView& frame) {
    view_ = frame;
    std::ranges::copy(frame.rgb, rgb_.begin());
    std::ranges::copy(frame.depth, depth_.begin());
    view_.intrinsics = &intrinsics_;
    view_.rgb = rgb_;
    view_.depth = depth_;
    any_ = true;
  }
  const hal::FrameView& view() const { return view_; }
  void let_go() { any_ = false; }  // the view stays good until the next one is held
  std::size_t bytes() const { return rgb_.size() + depth_.size() * sizeof(std::uint16_t); }

 private:
  hal::Intrinsics intrinsics_;
  std::vector<std::uint8_t> rgb_;
  std::vector<std::uint16_t> depth_;
  hal::FrameView view_;
  bool any_ = false;
};

}  // namespace onemap::mapping
