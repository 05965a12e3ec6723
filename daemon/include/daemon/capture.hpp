#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>

#include "daemon/config.hpp"
#include "daemon/frame_check.hpp"
#include "daemon/frame_times.hpp"
#include "daemon/heartbeat.hpp"
#include "daemon/log.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "hal/depth_camera.hpp"

namespace onemap::daemon {

struct CaptureCounters {
  std::uint64_t grabbed = 0, bad = 0, dropped = 0;
  std::uint64_t gone = 0;  // times that the camera went away
  // Frames that showed the same pixels as the one before, only black, only white, no depth (FrameCheck); and frames
  // that were not after the one before (FrameTimes).
  std::uint64_t frozen = 0, black = 0, saturated = 0, no_depth = 0, time_back = 0;
  // As the camera counts them (hal::CameraCounters): images without a partner in time, frames that nobody fetched.
  std::uint64_t unmatched = 0, missed = 0;
};

// What the camera says of itself, for people; another socket may change it.
struct CameraWords {
  std::string description, limits;  // hal::DepthCamera
  bool operator==(const CameraWords&) const = default;
};

// The capture thread: camera -> frame of the pool -> queue. At `max` it waits for the pipeline, so that every frame is
// processed; else it keeps the recording's pace and the oldest frame makes room, counted. A camera that goes away is
// waited for. Ends with the stream.
class Capture {
 public:
  Capture(hal::DepthCamera& camera, Speed speed, Failures& failures, Log& log);
  static std::uint64_t bytes_of(const hal::Intrinsics& camera);  // what the frames take that it will hold
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  // Before start(): who sees every frame on the capture thread, before the pipeline does. It must not wait.
  void listen(std::function<void(const hal::FrameView&)> listener) { listener_ = std::move(listener); }
  void start();
  void stop();  // no more frames; what is queued may still be taken
  BlockingQueue<hal::Frame>& frames() { return queue_; }
  bool ended() const { return ended_; }  // the stream came to its end by itself
  bool away() const { return away_; }    // the camera is gone, and waited for
  CaptureCounters counters() const;
  CameraWords words() const;  // as of when it was opened, or came back the last time
  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void run();
  void read_counters();       // the camera's: only its thread may
  void read_words();          // likewise, and says what is new
  void tell(hal::Grab grab);  // what became of the camera, once each time that it changes
  bool deliver(hal::Frame frame);
  bool usable(hal::Frame& frame);  // of a frame that came, whether it goes on from here
  bool times_increase(hal::Frame& frame);
  bool keep_pace(FrameTime time);  // false: stop
  hal::DepthCamera& camera_;
  const Speed speed_;
  Failures& failures_;
  Log& log_;
  std::function<void(const hal::FrameView&)> listener_;
  hal::FramePool pool_;
  BlockingQueue<hal::Frame> queue_;
  const bool live_;  // has its own pace
  std::atomic<std::uint64_t> grabbed_ = 0, bad_ = 0, gone_ = 0, time_back_ = 0;
  std::atomic<std::uint64_t> unmatched_ = 0, missed_ = 0;
  std::array<std::atomic<std::uint64_t>, kFrameFaults> faults_{};
  FrameCheck check_;
  FrameTimes times_;
  std::atomic<bool> away_ = false;  // the camera, as the log has it
  std::string why_away_;            // likewise
  std::atomic<bool> ended_ = false;
  bool stopping_ = false;  // with mutex_
  CameraWords words_;      // with mutex_
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool paced_ = false;  // the first frame set the pace's origin
  Instant origin_{};
  FrameTime origin_frame_{};
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
