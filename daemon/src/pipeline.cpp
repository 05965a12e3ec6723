#include "daemon/pipeline.hpp"

#include <fmt/format.h>

#include "daemon/clock.hpp"
#include "mapping/team/atlas.hpp"

namespace onemap::daemon {

namespace {
constexpr std::uint64_t kSubmapInterval = 15;  // integrations between two looks for settled blocks
constexpr std::size_t kSubmapBlocks = 256;
}  // namespace

Pipeline::Pipeline(const Config& config, const hal::Intrinsics& intrinsics, BlockingQueue<hal::Frame>& frames,
                   Outbox outbox, Failures& failures, Log& log)
    : config_(config),
      frames_(frames),
      outbox_(std::move(outbox)),
      failures_(failures),
      log_(log),
      mapper_(std::make_unique<mapping::LocalMapper>(config.mapper, intrinsics)) {
  mapping::LocalMapper::reserve_record(keyframe_, config.mapper);
  mapper_->set_step_hook(
      {[](void* self, mapping::Step step) { static_cast<Pipeline*>(self)->begin_step(step); }, this});
  if (config.matches_picture > 0) matches_.emplace(config.out + "/matches", config.matches_picture);
}

Pipeline::~Pipeline() {
  abandon();
  frames_.close();
  join();
}

void Pipeline::start() {
  thread_.start(
      "pipeline", failures_, [this] { run(); }, [this] { frames_.close(); });  // capture waits no longer
}

void Pipeline::join() { thread_.join(); }

PipelineProgress Pipeline::progress() const { return {frames_done_, tracked_, keyframes_, blocks_refused_, finished_}; }

void Pipeline::run() {
  while (auto frame = frames_.pop()) {
    if (abandoned_) break;
    process(frame->view());
  }
  mapper_->finish();
  drain();
  drain_submaps(0);
  if (outbox_.finish) outbox_.finish(static_cast<std::uint32_t>(frames_done_));
  finished_ = true;
}

void Pipeline::process(const hal::FrameView& frame) {
  const Duration before = thread_cpu_time();
  const mapping::FrameReport report = mapper_->process(frame);
  const Duration after = thread_cpu_time();
  frame_times_.add(after - before);
  log_change(frame, report);
  if (matches_) {
    if (auto status = matches_->frame(frame, report, *mapper_); !status)
      log_.limited("matches", "picture of matches: {}", status.error().text());
  }
  drain();
  const std::uint64_t integrated = mapper_->map().counters().integrated_frames;
  if (integrated >= last_submap_at_ + kSubmapInterval) {
    last_submap_at_ = integrated;
    drain_submaps(config_.submap_min_age);
  }
  publish_times_.add(thread_cpu_time() - after);
  ++frames_done_;
  tracked_ = mapper_->counters().tracked;
  keyframes_ = mapper_->counters().keyframes;
  log_full();
}

// Surfaces that the voxel map has no room for are missing from every picture and from everybody's map: say so.
void Pipeline::log_full() {
  const std::uint64_t refused = mapper_->map().counters().blocks_refused;
  if (refused == blocks_refused_) return;
  blocks_refused_ = refused;
  log_.limited("map full",
               "the voxel map is full ({} blocks): new surface is left out, {} blocks so far; raise map.budget_mb or "
               "map.voxel_m",
               mapper_->map().used(), refused);
}

void Pipeline::log_change(const hal::FrameView& frame, const mapping::FrameReport& report) {
  using mapping::TrackState;
  if (report.state == TrackState::lost && last_state_ != TrackState::lost) {
    lost_since_ = frame.index;
    log_.limited("lost", "tracking lost at frame {}: {} (features {}, matches {}, inliers {})", frame.index,
                 to_string(report.reason), report.features, report.matches, report.inliers);
  } else if (report.state == TrackState::tracking && last_state_ == TrackState::lost) {
    log_.limited("resumed", "tracking resumed at frame {} against keyframe {} after {} frames", frame.index,
                 report.reference_keyframe, frame.index - lost_since_);
  }
  last_state_ = report.state;
}

void Pipeline::begin_step(mapping::Step step) {
  const Duration t = thread_cpu_time();
  if (step_ < mapping::kSteps) step_time_[step_] += t - step_began_;
  step_ = static_cast<std::size_t>(step);
  step_began_ = t;
}

template <class Record>
void Pipeline::publish(mapping::Lane lane, mapping::RecordKind kind, const Record& record, std::uint32_t poses) {
  if (outbox_.publish) outbox_.publish({lane, kind, encode(record), poses});
}

void Pipeline::drain() {
  while (mapper_->take_keyframe(keyframe_)) {
    keyframe_poses_.push_back(keyframe_.T_robot_keyframe);
    publish(mapping::Lane::features, mapping::RecordKind::keyframe, keyframe_);
  }
  while (mapper_->take_poses(trajectory_)) {
    poses_.insert(poses_.end(), trajectory_.poses.begin(), trajectory_.poses.end());
    publish(mapping::Lane::poses, mapping::RecordKind::trajectory, trajectory_,
            static_cast<std::uint32_t>(trajectory_.poses.size()));
  }
}

void Pipeline::drain_submaps(std::uint64_t min_age) {
  if (!outbox_.publish) return;
  for (;;) {
    const auto blocks = mapper_->map().take_settled(min_age, kSubmapBlocks);
    if (blocks.empty()) break;
    publish(mapping::Lane::voxels, mapping::RecordKind::submap, mapping::make_submap(mapper_->map(), blocks));
  }
}

std::string Pipeline::step_table() const {
  Duration total{};
  for (const Duration d : step_time_) total += d;
  std::string text;
  const double frames = static_cast<double>(std::max<std::uint64_t>(1, frame_times_.count()));
  for (std::size_t i = 0; i < mapping::kSteps; ++i) {
    const double ms = to_seconds(step_time_[i]) * 1e3;
    text += fmt::format("{} {:.2f} ms ({:.0f} %), ", mapping::to_string(static_cast<mapping::Step>(i)), ms / frames,
                        100 * ms / std::max(1e-9, to_seconds(total) * 1e3));
  }
  return text + fmt::format("publish {:.2f} ms", publish_times_.total_ms() / frames);
}

}  // namespace onemap::daemon
