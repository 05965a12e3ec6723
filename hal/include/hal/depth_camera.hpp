#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "hal/base/result.hpp"
#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::hal {

enum class Grab {
  frame,    // the frame was filled
  bad,      // this frame could not be read: last_error() says where and why; the next one may be good
  timeout,  // nothing within the given time, and nothing known to be wrong
  gone,  // the device is not there, or has been silent for so long (hal/stall.hpp) that it is opened anew, and may come
         // back: last_error() says why. Keep calling: each call looks for it, and waits for it up to the timeout
  end,   // the stream is over for good (a recording's last frame)
};

struct CameraCounters {
  std::uint64_t frames = 0;     // delivered
  std::uint64_t bad = 0;        // unreadable, see last_error()
  std::uint64_t unmatched = 0;  // colour or depth images without a partner in time
  std::uint64_t missed = 0;     // frames that a live camera took and nobody fetched in time
};

// An RGB-D camera: registered colour and depth, oldest first, with strictly increasing colour times. Used by one
// thread. The intrinsics stay the same for its whole life: a device that comes back comes back with them.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  virtual const Intrinsics& intrinsics() const = 0;
  virtual Grab grab(Frame& into, std::chrono::milliseconds timeout) = 0;
  virtual const Error& last_error() const = 0;  // of the last Grab::bad or Grab::gone
  virtual CameraCounters counters() const = 0;
  // Frames come in real time, and are lost when they are not taken. False: a recording, which waits.
  virtual bool live() const = 0;
  // How sure its depth is; a structured-light sensor's (Kinect v1) when the camera does not know better.
  virtual DepthNoise depth_noise() const { return {}; }
  // Frames still to come, for progress bars; 0 when unknown (a live camera).
  virtual std::uint64_t frames_expected() const = 0;
  virtual std::string description() const = 0;  // for people: backend, place, resolution
  // For people: why it does less here than it could, a USB 3 camera on a USB 2 port; empty: it does not.
  virtual std::string limits() const { return {}; }
};

}  // namespace onemap::hal
