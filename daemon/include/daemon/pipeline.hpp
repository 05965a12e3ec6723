#pragma once
#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/depth_sense.hpp"
#include "daemon/heartbeat.hpp"
#include "daemon/latency.hpp"
#include "daemon/log.hpp"
#include "daemon/match_pictures.hpp"
#include "daemon/outgoing.hpp"
#include "daemon/publisher.hpp"
#include "daemon/step_times.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "hal/depth_camera.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/local/smooth_odometry.hpp"
#include "mapping/team/long_way.hpp"

namespace onemap::daemon {

// What the work loop has done so far; readable while it runs.
struct PipelineProgress {
  std::uint64_t frames = 0, tracked = 0;
  std::uint64_t keyframes = 0;       // in the map, those not yet sealed included
  std::uint64_t blocks_refused = 0;  // of the voxel map, for want of room
  bool finished = false;             // the queue was closed and empty, and everything is sealed and published
};

// Where the camera is by the last frame that was placed; readable while it runs.
struct PoseNow {
  bool tracking = false;
  FrameTime time{};
  mapping::Pose T_odom_camera, T_odom_robot;  // odom: smooth; robot: the frame of this robot's records
  std::uint32_t chain = 0;                    // of this chain: so many ended before it
};

// How it goes, for those who look after it; readable while it runs.
struct PipelineView {
  FrameCosts costs;
  std::array<std::uint64_t, static_cast<std::size_t>(mapping::TrackReason::count)> not_placed{};  // frames, by reason
  std::uint64_t times_lost = 0, relocalized = 0;
  std::size_t blocks = 0;  // of the local map's pool, in use
  std::uint32_t chains_ended = 0;
  std::optional<DepthLook> look;  // of a frame within the last second or so
  mapping::FocalEstimate focal;   // whether the lens is what the camera says
};

// The work thread: takes frames from the queue, runs the mapper's frame path, and hands what it sealed to the
// publisher. The mapper and its voxel map belong to this thread until finished.
class Pipeline {
 public:
  Pipeline(const Config& config, const hal::DepthCamera& camera, BlockingQueue<hal::Frame>& frames, Outbox outbox,
           Failures& failures, Log& log);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  void start();
  void abandon() { abandoned_ = true; }  // leave out what is still queued; finish with what there is
  void join();
  PipelineProgress progress() const;
  double brightness() const { return brightness_; }  // of the camera's images lately, 0..255; 0: none yet
  PoseNow pose() const;
  const Heartbeat& heartbeat() const { return heartbeat_; }
  const Heartbeat& publisher_heartbeat() const { return publisher_.heartbeat(); }
  PipelineView view() const;
  // Told after every frame, on the work thread: must be quick. Before start().
  void on_pose(std::function<void(const PoseNow&)> told) { told_ = std::move(told); }

  // After join().
  const mapping::LocalMapper& mapper() const { return *mapper_; }
  // All chains', in the first one's frame; bounded.
  std::vector<mapping::StampedPose> poses() const { return way_.poses(); }
  std::uint64_t keyframes_published() const { return keyframes_published_; }
  const LatencyHistogram& frame_times() const { return times_.frames(); }  // processor time of this thread
  std::string step_table() const;                                          // for the log: each step's mean and share

 private:
  void run();
  void make_mapper();
  // A camera that is lost for long where there is something to see is somewhere that the map does not have.
  void note_lost(const hal::FrameView& frame, const mapping::FrameReport& report);
  void note_length();
  void give_up(FrameTime lost);
  bool begin_chain();  // false: the publisher takes nothing more
  void seal_all();
  void process(const hal::FrameView& frame);
  void keep_pose(const hal::FrameView& frame, const mapping::FrameReport& report);
  void keep_view(const hal::FrameView& frame, const mapping::FrameReport& report);
  void log_full();
  void log_lens();
  void log_change(const hal::FrameView& frame, const mapping::FrameReport& report);
  // What the mapper sealed, into the publisher's slots.
  void drain();
  bool take(Publisher::Sealed& into);
  void keep(const Publisher::Sealed& sealed);
  void keep(mapping::StampedPose pose);
  void drain_submaps();
  bool hand_over(Publisher::Sealed* sealed, bool taken);  // taken, as given
  Publisher::Sealed* slot();

  const Config& config_;
  const hal::Intrinsics intrinsics_;
  const hal::DepthNoise noise_;
  BlockingQueue<hal::Frame>& frames_;
  Failures& failures_;
  Log& log_;
  std::unique_ptr<mapping::LocalMapper> mapper_;
  mapping::SmoothOdometry odometry_;
  mutable std::mutex pose_mutex_;  // of pose_ and view_
  PoseNow pose_;
  PipelineView view_;  // without the costs
  std::function<void(const PoseNow&)> told_;
  std::vector<std::uint16_t> depth_scratch_;
  std::optional<MatchPictures> matches_;
  Publisher publisher_;
  mapping::LongWay way_;
  std::uint64_t keyframes_published_ = 0, frames_before_ = 0, tracked_before_ = 0;  // before: of earlier chains
  std::uint32_t chains_ended_ = 0;
  FrameTime frame_time_{}, poses_due_{};     // of the present frame; poses are handed over no earlier
  mapping::Pose T_first_chain_, last_pose_;  // the present chain's frame in the first one's
  std::optional<FrameTime> lost_at_;         // since when it sees something and is lost
  Duration patience_{};
  mapping::TrackState last_state_ = mapping::TrackState::starting;
  std::uint64_t lost_since_ = 0;
  StepTimes times_;
  std::atomic<std::uint64_t> frames_done_ = 0, tracked_ = 0, keyframes_ = 0, blocks_refused_ = 0;
  bool ending_ = false;  // what is left is handed over, however long that takes
  std::atomic<bool> finished_ = false, abandoned_ = false;
  std::atomic<double> brightness_ = 0.0;
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
