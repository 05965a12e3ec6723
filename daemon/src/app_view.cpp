// What the app tells of itself.
#include <sys/statvfs.h>
#include <unistd.h>

#include <utility>

#include "daemon/app.hpp"
#include "daemon/clock.hpp"
#include "daemon/control/replies.hpp"

namespace onemap::daemon {

namespace {
PlaceFacts place_facts(const std::string& out) {
  PlaceFacts place;
  place.out = out;
  struct statvfs disk {};
  if (statvfs(out.c_str(), &disk) == 0)
    place.disk_free_bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  place.out_writable = access(out.c_str(), W_OK) == 0;
  return place;
}
}  // namespace

RobotFacts App::facts() const {
  RobotFacts facts;
  facts.id = config_.id;
  facts.version = ONEMAP_VERSION;
  facts.alone = config_.alone();
  if (!facts.alone) facts.listen = radio_->local();
  facts.now = now();
  facts.uptime_s = to_seconds(facts.now - began_);
  facts.rss_mb = rss_mb();
  facts.peak_rss_mb = daemon::peak_rss_mb();
  facts.status = status();
  facts.camera = camera_facts_;
  CameraWords words = capture_->words();
  facts.camera.description = std::move(words.description);
  facts.camera.limits = std::move(words.limits);
  facts.camera.away = capture_->away();
  facts.camera.ended = capture_->ended();
  facts.capture = capture_->counters();
  facts.pipeline = pipeline_->view();
  facts.local_blocks_most = mapping::VoxelMap::capacity_of(config_.mapper.map);
  mapping::VoxelMapConfig global = config_.mapper.map;
  global.budget_bytes = config_.global_budget_bytes;
  facts.global_blocks_most = mapping::VoxelMap::capacity_of(global);
  facts.team = team_->view();
  facts.links = team_->links();
  facts.radio = radio_->view();
  facts.recorder = recorder_->view();
  facts.snapshots = snapshots_->view();
  facts.life = facts.radio.life;
  facts.place = place_facts(config_.out);
  return facts;
}

DaemonStatus App::status() const {
  DaemonStatus s;
  const PipelineProgress progress = pipeline_->progress();
  s.frames = progress.frames;
  s.frames_expected = frames_expected_;
  s.tracked = progress.tracked;
  s.keyframes = progress.keyframes;
  const CaptureCounters captured = capture_->counters();
  s.frames_dropped = captured.dropped;
  s.frames_bad = captured.bad;
  s.frames_missed = captured.missed;
  s.images_unmatched = captured.unmatched;
  s.blocks_refused = progress.blocks_refused;
  const TeamView team = team_->view();
  const RadioView radio = radio_->view();
  s.map_digest = team.digest;
  s.robots_known = team.robots_known;
  s.robots_finished = team.robots_finished;
  s.robots_in_map = team.robots_in_map;
  for (const auto& [robot, keyframes] : team.keyframes_in_map) s.keyframes_in_map[robot.name()] = keyframes;
  s.frontier_digest = radio.frontier_digest;
  for (std::size_t k = 0; k < comms::kScalars; ++k)
    if (radio.scalars.values[k].known)
      s.consensus[std::string(name(static_cast<comms::Scalar>(k)))] = radio.scalars.values[k].agreed;
  s.refused = refusals(team, radio);
  s.waiting = standing_.waiting;
  s.stuck = standing_.stuck;
  s.agreed = standing_.agreed;
  s.map_agreed = map_agreement_.agreed();
  s.map_differs.reserve(map_agreement_.differing().size());
  for (const RobotId& robot : map_agreement_.differing()) s.map_differs.push_back(robot.name());
  const PoseNow pose = pipeline_->pose();
  s.tracking = pose.tracking;
  s.pose_time_s = to_seconds(pose.time.time_since_epoch());
  s.T_odom_camera = pose.T_odom_camera;
  s.T_map_odom = map_correction(team, pose);
  s.state = progress.finished && team.settled ? "settled" : progress.finished ? "merging" : "tracking";
  return s;
}

}  // namespace onemap::daemon
