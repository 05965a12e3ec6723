#pragma once
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/mcap/mcap_recording.hpp"
#include "daemon/recording_writer.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::daemon {

struct RecorderConfig {
  std::uint64_t limit_bytes = std::uint64_t{4096} << 20;      // of one recording
  std::uint64_t least_free_bytes = std::uint64_t{512} << 20;  // of the disk, left to others
  bool tum = true, mcap = false;                              // what is written: see record.formats
  bool every_frame = false;  // whoever offers waits for room instead of losing the frame: at --speed max
};

RecorderConfig recorder_config(const Config& config);

struct RecorderView {
  bool recording = false;
  std::string folder;  // of this recording or the last one; empty: none yet
  std::uint64_t frames = 0, bytes = 0;
  std::uint64_t dropped = 0;  // frames that came faster than the disk takes them
  std::string ended;          // why it ended by itself: a limit, a disk; empty: it did not
};

// Where a recording goes when nobody says: OUT/recordings/0001, and so on.
std::string next_recording(const std::string& out);

// Records what the camera delivers, on a thread of its own behind a queue of a few frames, so that neither the camera
// nor the map waits for a disk. One recording at a time; its memory is taken when it starts. A recording that meets its
// limit, or a disk that is full or fails, ends by itself and says so; the daemon goes on. Thread safe.
class Recorder {
 public:
  static constexpr std::size_t kQueued = 8;  // frames

  Recorder(const RecorderConfig& config, RecordedCamera camera, TruthLine truth, Log& log);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Refused while one is running, and for a folder that holds one or cannot be written to.
  Status start(const std::string& folder);
  // What was offered is written before it returns. Nothing happens when none is running. The view of what was stopped.
  RecorderView stop();
  bool wants_poses() const { return recording_ && config_.mcap; }
  void offer(const hal::FrameView& frame);  // the camera's thread
  // Any thread; never waits. Where the camera was, for recording.mcap; what comes between two frames that are written
  // is kept up to kPoses, and of more the oldest goes.
  static constexpr std::size_t kPoses = 256;
  void pose(const RecordedPose& pose);
  RecorderView view() const;

 private:
  // One recording.
  struct Session {
    Session(std::string where, const hal::Intrinsics& intrinsics)
        : folder(std::move(where)), pool(intrinsics, kQueued), queue(kQueued) {}
    const std::string folder;
    std::optional<RecordingWriter> tum;  // these two are the thread's
    std::optional<McapRecording> mcap;
    hal::FramePool pool;
    BlockingQueue<hal::Frame> queue;
    std::mutex pose_mutex;
    std::deque<RecordedPose> poses;
    std::atomic<std::uint64_t> frames = 0, bytes = 0, dropped = 0;
    std::atomic<bool> open = true;  // takes frames
    Worker thread;
  };
  Status open(Session& session) const;
  Status write_poses(Session& session);
  void run(Session& session);
  Status write(Session& session, const hal::FrameView& frame);
  Status room(const Session& session) const;
  void end(Session& session, const Error& why);

  const RecorderConfig config_;
  const RecordedCamera camera_;
  const TruthLine truth_;
  Log& log_;
  std::mutex control_;                // of start and stop: one at a time
  mutable std::mutex mutex_;          // of session_ and view_
  std::shared_ptr<Session> session_;  // running, or ended by itself
  RecorderView view_;                 // of the last one, but what the session counts
  std::atomic<bool> recording_ = false;
  Failures failures_;  // a recording that fails is no failure of the daemon
};

}  // namespace onemap::daemon
