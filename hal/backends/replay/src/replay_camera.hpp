#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/imaging/image_file.hpp"
#include "recording.hpp"

namespace onemap::hal::replay {

// Plays a recording's chosen part. Lines of its lists that could not be used come first, each as one Grab::bad.
class ReplayCamera final : public DepthCamera {
 public:
  // Finds the image size by reading frames until one is good; the error is the first frame's when none is.
  static Result<std::unique_ptr<DepthCamera>> open(Recording recording);

  const Intrinsics& intrinsics() const override { return recording_.intrinsics; }
  Grab grab(Frame& into, std::chrono::milliseconds timeout) override;
  const Error& last_error() const override { return last_error_; }
  CameraCounters counters() const override { return counters_; }
  DepthNoise depth_noise() const override { return recording_.calibration.noise(); }
  bool live() const override { return false; }
  std::uint64_t frames_expected() const override { return recording_.to - next_; }
  std::string description() const override;

 private:
  explicit ReplayCamera(Recording recording);
  Status find_size();
  Status size_of(const ListedPair& pair, imaging::ImageSize& size);
  Status read_pair(const ListedPair& pair, imaging::ImageSize size, std::span<std::uint8_t> rgb,
                   std::span<std::uint16_t> depth);
  Status load(const ListedImage& image, const std::string& list);
  Error at_file(const ListedImage& image, const std::string& list, const std::string& reason) const;

  Recording recording_;
  std::size_t next_;  // the pair that grab() reads next
  std::size_t problems_told_ = 0;
  std::vector<std::uint8_t> file_;  // the bytes of the file at hand
  Error last_error_;
  CameraCounters counters_;
};

}  // namespace onemap::hal::replay
