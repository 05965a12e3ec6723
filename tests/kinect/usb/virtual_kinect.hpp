#pragma once
// A Kinect on a bus that umockdev plays, which takes a picture when its camera is asked for a frame, so that none is
// lost however busy the machine is.
#include <atomic>
#include <memory>
#include <string>

#include "cameras/film.hpp"
#include "cameras/kinect_device.hpp"
#include "hal/backends/libusb.hpp"
#include "mock_bus.hpp"

namespace onemap::test {

// Shows the next picture of a film, over and over, once it is pressed; a thirtieth of a second after the last by the
// camera's clock.
class Shutter final : public Projector {
 public:
  explicit Shutter(std::size_t pictures) : pictures_(pictures) {}
  void press() { pressed_ = shown_ + 1; }

  bool advance(bool wanted, Moment) override { return wanted && shown_ < pressed_ && ++shown_ > 0; }
  std::size_t number() const override { return (shown_ - 1) % pictures_; }
  std::chrono::nanoseconds stamp() const override { return shown_.load() * FilmProjector::kInterval; }
  Moment since() const override { return {}; }  // long ago
  Moment next() const override { return Moment::max(); }
  void stop() override { shown_ = pressed_.load(); }

 private:
  const std::size_t pictures_;
  std::atomic<std::size_t> pressed_ = 0, shown_ = 0;
};

class VirtualKinect {
 public:
  VirtualKinect(MockBus& bus, int socket, const Film& film, const std::string& serial)
      : bus_(bus), socket_(socket), shutter_(film.pictures().size()), device_(film, shutter_, serial) {}
  void plug() { bus_.plug(socket_, device_); }
  void unplug() { bus_.unplug(socket_); }
  void pull_out_at(int request) { bus_.pull_out_at(socket_, request); }
  void pause(bool paused) { paused_ = paused; }
  std::size_t picture() const { return shutter_.number(); }  // of the film, the last that was shown
  bool release() {
    if (paused_) return false;
    shutter_.press();
    bus_.step(socket_);
    return true;
  }

 private:
  MockBus& bus_;
  const int socket_;
  bool paused_ = false;
  Shutter shutter_;
  KinectDevice device_;
};

// The camera, whose device takes one picture a frame.
class OnDemand final : public hal::DepthCamera {
 public:
  OnDemand(std::unique_ptr<hal::DepthCamera> camera, VirtualKinect& device)
      : camera_(std::move(camera)), device_(device) {}
  hal::Grab grab(hal::Frame& into, std::chrono::milliseconds timeout) override {
    if (there_ && !on_its_way_) on_its_way_ = device_.release();
    const hal::Grab grab = camera_->grab(into, timeout);
    there_ = grab != hal::Grab::gone;  // else it would show a picture while its streams begin
    on_its_way_ = on_its_way_ && grab == hal::Grab::timeout;
    return grab;
  }
  const hal::Intrinsics& intrinsics() const override { return camera_->intrinsics(); }
  const Error& last_error() const override { return camera_->last_error(); }
  hal::CameraCounters counters() const override { return camera_->counters(); }
  bool live() const override { return camera_->live(); }
  hal::DepthNoise depth_noise() const override { return camera_->depth_noise(); }
  std::uint64_t frames_expected() const override { return camera_->frames_expected(); }
  std::string description() const override { return camera_->description(); }
  std::string limits() const override { return camera_->limits(); }

 private:
  std::unique_ptr<hal::DepthCamera> camera_;
  VirtualKinect& device_;
  bool there_ = true, on_its_way_ = false;
};

}  // namespace onemap::test
