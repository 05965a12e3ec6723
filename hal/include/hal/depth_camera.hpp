#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "hal/base/result.hpp"
#include "hal/frame.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::hal {

enum class Grab {
  frame,    // the frame was filled
  bad,      // this frame could not be read: last_error() says where and why; the next one may be good
  timeout,  // nothing within the given time
  end,      // the stream is over (a recording's last frame, a camera that left for good)
};

struct CameraCounters {
  std::uint64_t frames = 0;     // delivered
  std::uint64_t bad = 0;        // unreadable, see last_error()
  std::uint64_t unmatched = 0;  // colour or depth images without a partner in time
};

// An RGB-D camera: registered colour and depth, oldest first, with the colour image's time, strictly increasing.
// Used by one thread.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  virtual const Intrinsics& intrinsics() const = 0;
  virtual Grab grab(Frame& into, std::chrono::milliseconds timeout) = 0;
  virtual const Error& last_error() const = 0;  // of the last Grab::bad
  virtual CameraCounters counters() const = 0;
  // Frames still to come, for progress bars; 0 when unknown (a live camera).
  virtual std::uint64_t frames_expected() const = 0;
  virtual std::string description() const = 0;  // for people: backend, place, resolution
};

}  // namespace onemap::hal
