#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "address.hpp"
#include "hal/backends/libusb/ticks.hpp"
#include "hal/depth_camera.hpp"
#include "hal/device_clock.hpp"
#include "hal/imaging/pair_by_time.hpp"
#include "hal/imaging/raw_depth.hpp"
#include "hal/imaging/register_depth.hpp"
#include "hal/stall.hpp"
#include "kinect.hpp"
#include "usb.hpp"

namespace onemap::hal::libusb {

class LibusbCamera final : public DepthCamera {
 public:
  static Result<std::unique_ptr<DepthCamera>> open(Address address);

  const Intrinsics& intrinsics() const override { return colour_; }
  Grab grab(Frame& into, std::chrono::milliseconds timeout) override;
  const Error& last_error() const override { return error_; }
  CameraCounters counters() const override;
  DepthNoise depth_noise() const override { return address_.lenses.calibration.noise(); }
  bool live() const override { return true; }
  std::uint64_t frames_expected() const override { return 0; }
  std::string description() const override { return description_; }

 private:
  static constexpr std::size_t kWaiting = 2;  // images of a stream that may wait for a partner
  using Outcome = imaging::PairByTime::Outcome;

  LibusbCamera(Address address, std::unique_ptr<Usb> usb, std::unique_ptr<Freenect> freenect);
  Status connect_named();  // the one that the address names, for the first time
  Status connect(const std::vector<Plugged>& all, std::size_t index);
  std::optional<std::size_t> ours_among(const std::vector<Plugged>& all) const;
  Status prepare();
  Grab grab_connected(Frame& into, std::chrono::milliseconds timeout);
  Grab grab_gone(Frame& into, std::chrono::milliseconds timeout);
  bool reconnect();
  void look_anew();
  Grab stalled();
  Grab lose_device(const std::string& why, std::chrono::milliseconds silent = {});
  void take(const ImageRing::Image& image);
  bool next_pair(Outcome& pair);
  Grab deliver(const Outcome& pair, Frame& into);
  void write_colour(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> rgb) const;
  void write_depth(std::span<const std::uint8_t> bytes, std::span<std::uint16_t> depth);
  ImageRing::Image& held(Stream stream, std::uint32_t slot) { return held_[stream == Stream::depth ? 0 : 1][slot]; }

  const Address address_;
  std::unique_ptr<Usb> usb_;            // before what runs on it
  std::unique_ptr<Freenect> freenect_;  // not open: gone
  Plugged ours_;                        // where the camera is now, or was; its serial number may be empty
  std::vector<Plugged> beside_;         // that were there when it was opened: none of them is ours
  std::string model_ = "Kinect v1";
  Intrinsics colour_;
  std::string description_;
  std::optional<imaging::PairByTime> pairs_;
  std::array<std::array<ImageRing::Image, 8>, 2> held_{};  // by slot
  std::array<std::uint64_t, 8> indices_{};                 // of the colour images, by slot
  imaging::KinectDisparity to_mm_;
  std::unique_ptr<imaging::DepthRegistration> registration_;  // null: depth comes registered
  std::vector<std::uint16_t> mm_;                             // of disparities that we register
  Ticks ticks_;
  DeviceClock clock_;
  Stall stall_;
  std::chrono::milliseconds away_{}, looked_at_{};  // since it left; when the bus was last looked at anew
  std::uint64_t index_ = 0, next_number_ = 0;
  CameraCounters counters_;
  Error error_;
};

}  // namespace onemap::hal::libusb
