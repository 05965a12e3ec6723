#pragma once
#include <OpenNI.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "address.hpp"
#include "device.hpp"
#include "hal/depth_camera.hpp"
#include "hal/device_clock.hpp"
#include "hal/imaging/pair_by_time.hpp"
#include "hal/imaging/register_depth.hpp"
#include "hal/stall.hpp"
#include "library.hpp"

namespace onemap::hal::openni2 {

class OpenNi2Camera final : public DepthCamera {
 public:
  static Result<std::unique_ptr<DepthCamera>> open(Address address);

  const Intrinsics& intrinsics() const override { return colour_; }
  Grab grab(Frame& into, std::chrono::milliseconds timeout) override;
  const Error& last_error() const override { return error_; }
  CameraCounters counters() const override;
  DepthNoise depth_noise() const override { return address_.lenses.calibration.noise(); }
  bool live() const override { return !address_.file; }
  std::uint64_t frames_expected() const override;
  std::string description() const override { return description_; }

 private:
  static constexpr std::size_t kWaiting = 4;  // images of a stream that may wait for a partner
  using Image = imaging::PairByTime::Image;

  OpenNi2Camera(Address address, std::shared_ptr<Library> library, std::unique_ptr<Hotplug> hotplug);
  Status connect();  // the device that the address names, for the first time
  void opened();     // who is beside it, and what it is
  void describe();
  Grab grab_connected(Frame& into, std::chrono::milliseconds timeout);
  Grab grab_gone(Frame& into, std::chrono::milliseconds timeout);
  bool reconnect();
  void look_anew();
  Grab lose_device(const std::string& why, std::chrono::milliseconds silent = {});
  Grab stalled();
  Grab broken(const Error& error);
  void take(Device::Image kind, openni::VideoFrameRef& image);
  bool next_pair(imaging::PairByTime::Outcome& pair);
  Grab deliver(const imaging::PairByTime::Outcome& pair, Frame& into);
  Status decode(const imaging::PairByTime::Outcome& pair, Frame& into);
  Status fill_depth(const imaging::RawImage& image, std::span<std::uint16_t> depth);
  void count_colour(int frame_index);
  openni::VideoFrameRef& held(const Image& image) { return held_[image.buffer]; }

  const Address address_;
  std::shared_ptr<Library> library_;  // before what was opened through it
  std::unique_ptr<Hotplug> hotplug_;  // null when the library could not be loaded anew
  std::unique_ptr<Device> device_;    // null: gone
  Identity identity_;                 // of the device that the camera began with
  std::vector<std::string> beside_;   // URIs of what was there when it was opened: none of them is ours
  Intrinsics colour_;
  std::string description_;
  std::optional<imaging::PairByTime> pairs_;
  std::array<openni::VideoFrameRef, 4 * kWaiting> held_;      // depth in the first half, colour in the second
  std::array<std::uint64_t, 4 * kWaiting> numbers_{};         // of the colour images, from 1
  std::array<std::size_t, 2> next_slot_{};                    // depth, colour
  std::unique_ptr<imaging::DepthRegistration> registration_;  // null: depth comes registered
  std::vector<std::uint16_t> unregistered_;
  DeviceClock clock_;
  Stall stall_;
  std::chrono::milliseconds away_{}, looked_at_{};  // since it left; when the drivers were last begun anew
  std::chrono::milliseconds silent_{};              // waited for the recording's next image
  bool over_ = false;
  std::uint64_t index_ = 0;  // colour images that the device took so far
  int last_frame_index_ = 0;
  CameraCounters counters_;
  Error error_;
};

}  // namespace onemap::hal::openni2
