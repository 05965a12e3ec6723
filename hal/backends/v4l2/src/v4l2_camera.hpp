#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device.hpp"
#include "hal/depth_camera.hpp"
#include "hal/imaging/pair_by_time.hpp"
#include "hal/stall.hpp"
#include "stream.hpp"
#include "timer.hpp"

namespace onemap::hal::v4l2 {

// Two streaming nodes as one camera; see hal/backends/v4l2.hpp. It outlives its device: when a stream breaks both are
// closed, and grab() opens them again at the same sockets.
class V4l2Camera final : public DepthCamera {
 public:
  static Result<std::unique_ptr<DepthCamera>> open(const V4l2Address& address);

  const Intrinsics& intrinsics() const override { return colour_; }
  Grab grab(Frame& into, std::chrono::milliseconds timeout) override;
  const Error& last_error() const override { return last_error_; }
  CameraCounters counters() const override { return counters_; }
  bool live() const override { return true; }
  DepthNoise depth_noise() const override { return rig_.noise; }
  std::uint64_t frames_expected() const override { return 0; }
  std::string description() const override;
  std::string limits() const override { return limits_of(device_.depth); }

 private:
  V4l2Camera(V4l2Address address, Device device, const imaging::RigCalibration& rig, std::string source, Timer timer);
  Status choose_sizes();
  Status start();  // both streams, from the nodes of device_
  bool come_back();
  Grab lose(Error why);
  Grab stalled();

  // One look at both streams; nothing: neither had an image.
  enum class Looked { nothing, something, gone };
  Looked look(Stream& stream, bool colour);
  Looked look_at_both();
  std::optional<Grab> settle(Frame& into);
  Grab deliver(const imaging::PairByTime::Outcome& pair, Frame& into);
  Status fill_depth(std::uint32_t buffer, Frame& into, bool& lent);
  enum class Woken { time, image, trouble };
  Woken wait(bool streaming);

  const V4l2Address address_;
  Device device_;
  const imaging::RigCalibration rig_;
  const std::string calibration_source_;
  Timer timer_;
  Intrinsics colour_, depth_;
  std::optional<imaging::DepthRegistration> registration_;
  std::vector<std::uint16_t> plain_depth_;  // for registration, of rows that are not as it needs them
  std::shared_ptr<Stream> depth_stream_, colour_stream_;
  std::vector<Stream::Image> depth_images_, colour_images_;  // by buffer: what was taken and not given back
  std::optional<imaging::PairByTime> pairs_;
  CameraCounters counters_;
  Stall stall_;
  std::uint64_t next_index_ = 0;
  Error last_error_;
};

}  // namespace onemap::hal::v4l2
