#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>

#include "daemon/config.hpp"
#include "daemon/heartbeat.hpp"
#include "daemon/log.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "hal/depth_camera.hpp"

namespace onemap::daemon {

struct CaptureCounters {
  std::uint64_t grabbed = 0, bad = 0, dropped = 0;
  std::uint64_t gone = 0;  // times that the camera went away
};

// The capture thread: camera -> frame of the pool -> queue. At `max` it waits for the pipeline, so that every frame is
// processed; else it keeps the recording's pace and the oldest frame makes room, counted. A camera that goes away is
// waited for. Ends with the stream.
class Capture {
 public:
  Capture(hal::DepthCamera& camera, Speed speed, Failures& failures, Log& log);
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  void start();
  void stop();  // no more frames; what is queued may still be taken
  BlockingQueue<hal::Frame>& frames() { return queue_; }
  bool ended() const { return ended_; }  // the stream came to its end by itself
  bool away() const { return away_; }    // the camera is gone, and waited for
  CaptureCounters counters() const;
  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void run();
  void tell(hal::Grab grab);  // what became of the camera, once each time that it changes
  bool deliver(hal::Frame frame);
  bool keep_pace(FrameTime time);  // false: stop
  hal::DepthCamera& camera_;
  const Speed speed_;
  Failures& failures_;
  Log& log_;
  hal::FramePool pool_;
  BlockingQueue<hal::Frame> queue_;
  const bool live_;  // has its own pace
  std::atomic<std::uint64_t> grabbed_ = 0, bad_ = 0, gone_ = 0;
  std::atomic<bool> away_ = false;  // the camera, as the log has it
  std::atomic<bool> ended_ = false;
  bool stopping_ = false;  // with mutex_
  std::mutex mutex_;
  std::condition_variable wake_;
  bool paced_ = false;  // the first frame set the pace's origin
  Instant origin_{};
  FrameTime origin_frame_{};
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
