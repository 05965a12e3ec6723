#include "daemon/pipeline.hpp"

#include <fmt/format.h>

#include "daemon/brightness.hpp"
#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr double kBrightnessFrames = 100;  // how long it remembers

constexpr int kSomethingToSee = 100;          // features
constexpr std::uint64_t kShortChain = 10;     // keyframes
constexpr std::uint64_t kLookEach = 15;       // frames
constexpr std::size_t kMostPoses = 1u << 20;  // 38 MB; of a longer way every second, fourth, ... is written
constexpr auto kLongestPatience = std::chrono::minutes(5);
constexpr auto kPosesEach = std::chrono::seconds(1);    // a record of the way: its head is as long as seven poses
constexpr auto kStuckAfter = std::chrono::seconds(10);  // a frame, or one piece handed over

}  // namespace

Pipeline::Pipeline(const Config& config, const hal::DepthCamera& camera, BlockingQueue<hal::Frame>& frames,
                   Outbox outbox, Failures& failures, Log& log)
    : config_(config),
      intrinsics_(camera.intrinsics()),
      noise_(camera.depth_noise()),
      frames_(frames),
      failures_(failures),
      log_(log),
      publisher_(config.mapper, config.speed.max ? Publisher::WhenFull::wait : Publisher::WhenFull::later,
                 std::move(outbox), failures),
      way_(kMostPoses),
      patience_(seconds(config.new_chain_after_s)),
      heartbeat_("pipeline", kStuckAfter) {
  make_mapper();
  if (config.matches_picture > 0) matches_.emplace(config.out + "/matches", config.matches_picture);
}

Pipeline::~Pipeline() {
  abandon();
  frames_.close();
  join();
}

void Pipeline::start() {
  publisher_.start();
  thread_.start(
      "pipeline", failures_, [this] { run(); }, [this] { frames_.close(); });  // capture waits no longer
}

void Pipeline::join() { thread_.join(); }

PipelineProgress Pipeline::progress() const { return {frames_done_, tracked_, keyframes_, blocks_refused_, finished_}; }

void Pipeline::make_mapper() {
  mapper_.reset();  // its memory first
  mapper_ = std::make_unique<mapping::LocalMapper>(config_.mapper, intrinsics_, noise_);
  mapper_->set_step_hook(
      {[](void* times, mapping::Step step) { static_cast<StepTimes*>(times)->begin(step, thread_cpu_time()); },
       &times_});
}

void Pipeline::seal_all() {
  mapper_->finish();
  ending_ = true;
  drain();
  drain_submaps();
  ending_ = false;
}

void Pipeline::note_lost(const hal::FrameView& frame, const mapping::FrameReport& report) {
  const bool lost = report.state == mapping::TrackState::lost && report.features >= kSomethingToSee;
  if (!lost) return lost_at_.reset();
  if (!lost_at_) lost_at_ = frame.colour_time;
  if (patience_ > Duration::zero() && frame.colour_time - *lost_at_ >= patience_) give_up(*lost_at_);
}

// Chains that come to nothing come ever more seldom.
void Pipeline::give_up(FrameTime lost) {
  const bool short_one = mapper_->counters().keyframes < kShortChain;
  patience_ = short_one ? std::min<Duration>(2 * patience_, kLongestPatience) : seconds(config_.new_chain_after_s);
  if (begin_chain())
    log_.warn(
        "lost since {:.1f} s: going on in a map of its own, until somebody knows where it belongs; drive it to "
        "where the team has been, more slowly and with more light; onemapctl doctor says what else is wrong",
        to_seconds(lost.time_since_epoch()));
}

// Nobody takes more keyframes of one chain.
void Pipeline::note_length() {
  const auto keyframes = mapper_->counters().keyframes;
  if (keyframes >= static_cast<std::uint64_t>(config_.chain_keyframes) && begin_chain())
    log_.line("{} keyframes: going on in a new map, which is joined to the earlier one as soon as it is seen again",
              keyframes);
}

bool Pipeline::begin_chain() {
  seal_all();
  Publisher::Sealed* end = publisher_.awaited_slot();
  if (end == nullptr) return false;
  end->what = Publisher::Sealed::What::chain_end;
  end->frames = static_cast<std::uint32_t>(frames_done_ - frames_before_);
  publisher_.publish(end);
  frames_before_ = frames_done_;
  tracked_before_ += mapper_->counters().tracked;
  ++chains_ended_;
  T_first_chain_ = T_first_chain_ * last_pose_;
  last_pose_ = {};
  odometry_.begin_chain();
  lost_at_.reset();
  last_state_ = mapping::TrackState::starting;
  make_mapper();
  return true;
}

void Pipeline::run() {
  while (auto frame = frames_.pop()) {
    if (abandoned_) break;
    heartbeat_.beat(now());
    process(frame->view());
    heartbeat_.rest();
  }
  heartbeat_.beat(now());
  seal_all();
  publisher_.finish(static_cast<std::uint32_t>(frames_done_ - frames_before_));
  publisher_.join();
  finished_ = true;
  heartbeat_.rest();
}

void Pipeline::process(const hal::FrameView& frame) {
  const Duration before = thread_cpu_time();
  frame_time_ = frame.colour_time;
  const mapping::FrameReport report = mapper_->process(frame);
  const Duration after = thread_cpu_time();
  times_.end_frame(after - before);
  const double light = brightness_of(frame.rgb), before_it = brightness_;
  brightness_ = frames_done_ == 0 ? light : before_it + (light - before_it) / kBrightnessFrames;
  keep_pose(frame, report);
  keep_view(frame, report);
  log_change(frame, report);
  if (matches_) {
    if (auto status = matches_->frame(frame, report, *mapper_); !status)
      log_.limited("matches", "picture of matches: {}", status.error().text());
  }
  drain();
  drain_submaps();
  ++frames_done_;
  tracked_ = tracked_before_ + mapper_->counters().tracked;
  keyframes_ = mapper_->counters().keyframes_in_map();
  log_full();
  if (report.keyframe_added) log_lens();
  note_lost(frame, report);
  note_length();
}

void Pipeline::keep_pose(const hal::FrameView& frame, const mapping::FrameReport& report) {
  odometry_.add(report);
  if (report.placed()) last_pose_ = report.T_robot_camera;
  {
    const std::lock_guard lock(pose_mutex_);
    pose_.tracking = report.state == mapping::TrackState::tracking;
    if (report.placed())
      pose_ = {true, frame.colour_time, odometry_.camera_in_odom(), odometry_.robot_in_odom(), chains_ended_};
  }
  if (told_) told_(pose_);  // this thread alone writes it
}

void Pipeline::keep_view(const hal::FrameView& frame, const mapping::FrameReport& report) {
  const auto blocks = mapper_->counters().blocks;
  const std::optional<mapping::FocalEstimate> focal =
      report.keyframe_added ? std::optional(mapper_->focal()) : std::nullopt;
  std::optional<DepthLook> look;
  if (frames_done_ % kLookEach == 0) look = look_at(frame, depth_scratch_);
  const std::lock_guard lock(pose_mutex_);
  if (!report.placed()) ++view_.not_placed[static_cast<std::size_t>(report.reason)];
  if (report.state == mapping::TrackState::lost && last_state_ == mapping::TrackState::tracking) ++view_.times_lost;
  if (report.relocalized) ++view_.relocalized;
  view_.blocks = blocks;
  view_.chains_ended = chains_ended_;
  if (look) view_.look = look;
  if (focal) view_.focal = *focal;
}

PipelineView Pipeline::view() const {
  PipelineView view;
  {
    const std::lock_guard lock(pose_mutex_);
    view = view_;
  }
  view.costs = times_.costs();
  return view;
}

PoseNow Pipeline::pose() const {
  const std::lock_guard lock(pose_mutex_);
  return pose_;
}

// Surfaces that the voxel map has no room for are missing from every picture and from everybody's map: say so.
void Pipeline::log_full() {
  const mapping::LocalMapperCounters counters = mapper_->counters();
  const std::uint64_t refused = counters.surface.blocks_refused;
  if (refused == blocks_refused_) return;
  blocks_refused_ = refused;
  log_.limited("map full",
               "the voxel map is full ({} blocks): new surface is left out, {} blocks so far; raise map.budget_mb or "
               "map.voxel_m",
               counters.blocks, refused);
}

void Pipeline::log_lens() {
  const mapping::FocalEstimate focal = mapper_->focal();
  if (focal.wrong()) log_.limited("lens", "{}; {}", doubt(focal), kCalibrate);
}

void Pipeline::log_change(const hal::FrameView& frame, const mapping::FrameReport& report) {
  using mapping::TrackState;
  if (report.state == TrackState::lost && last_state_ != TrackState::lost) {
    lost_since_ = frame.index;
    log_.limited(
        "lost",
        "tracking lost at frame {}: {} (features {}, matches {}, inliers {}); turn slower, or back to what it saw",
        frame.index, to_string(report.reason), report.features, report.matches, report.inliers);
  } else if (report.state == TrackState::tracking && last_state_ == TrackState::lost) {
    log_.limited(Level::info, "resumed", "tracking resumed at frame {} against keyframe {} after {} frames",
                 frame.index, report.reference_keyframe, frame.index - lost_since_);
  }
  last_state_ = report.state;
}

Publisher::Sealed* Pipeline::slot() { return ending_ ? publisher_.awaited_slot() : publisher_.slot(); }

bool Pipeline::take(Publisher::Sealed& into) {
  using What = Publisher::Sealed::What;
  into.what = What::keyframe;
  if (mapper_->take_keyframe(into.keyframe)) return true;
  into.what = What::poses;
  if (!ending_ && frame_time_ < poses_due_) return false;
  if (mapper_->take_poses(into.poses)) return true;
  poses_due_ = frame_time_ + kPosesEach;
  return false;
}

void Pipeline::keep(const Publisher::Sealed& sealed) {
  if (sealed.what == Publisher::Sealed::What::keyframe) ++keyframes_published_;
  if (sealed.what != Publisher::Sealed::What::poses) return;
  for (const mapping::StampedPose& pose : sealed.poses.poses) keep(pose);
}

void Pipeline::keep(mapping::StampedPose pose) {
  if (frames_before_ != 0) pose.T_robot_camera = quantize(T_first_chain_ * from_quantized(pose.T_robot_camera));
  const std::uint64_t each = way_.each();
  way_.add(pose);
  if (way_.each() != each) log_.line("the way is long: of trajectory.txt every {}th pose is kept", way_.each());
}

void Pipeline::drain() {
  while (Publisher::Sealed* sealed = slot()) {
    const bool taken = take(*sealed);
    if (taken) keep(*sealed);
    if (!hand_over(sealed, taken)) break;
  }
}

bool Pipeline::hand_over(Publisher::Sealed* sealed, bool taken) {
  heartbeat_.beat(now());
  if (taken)
    publisher_.publish(sealed);
  else
    publisher_.give_back(sealed);
  return taken;
}

void Pipeline::drain_submaps() {
  while (Publisher::Sealed* sealed = slot()) {
    sealed->what = Publisher::Sealed::What::submap;
    const bool taken = mapper_->take_submap(sealed->submap);
    if (!hand_over(sealed, taken)) break;
  }
}

std::string Pipeline::step_table() const {
  const FrameCosts costs = times_.costs();
  double total_ms = 0;
  for (const Cost& step : costs.steps) total_ms += step.total_ms;
  std::string text;
  const double frames = static_cast<double>(std::max<std::uint64_t>(1, costs.frame.count));
  for (std::size_t i = 0; i < mapping::kSteps; ++i) {
    const double ms = costs.steps[i].total_ms;
    text += fmt::format("{} {:.2f} ms ({:.0f} %), ", mapping::to_string(static_cast<mapping::Step>(i)), ms / frames,
                        100 * ms / std::max(1e-6, total_ms));
  }
  return text + fmt::format("beside them publish {:.2f} ms", publisher_.times().total_ms() / frames);
}

}  // namespace onemap::daemon
