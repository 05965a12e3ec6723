#include "daemon/app.hpp"

#include "daemon/cameras.hpp"
#include "daemon/clock.hpp"
#include "mapping/local/surface.hpp"
#include "mapping/records/hello.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kTick = std::chrono::milliseconds(50);
constexpr auto kStatusInterval = std::chrono::milliseconds(250);
}  // namespace

App::App(Config config, Log& log) : config_(std::move(config)), log_(log) {}

Exit App::run(StopSignals& signals) {
  if (auto status = open(); !status) {
    log_.line("{}", status.error().text());
    return Exit::usage;
  }
  start();
  const bool done = work_until_done(signals);
  stop();
  if (auto status = write_all(); !status) {
    log_.line("{}", status.error().text());
    return Exit::failed;
  }
  if (pipeline_->progress().tracked == 0) {
    log_.line("no frame could be placed: there is no map");
    return Exit::failed;
  }
  log_.line("{}; everything is in {}", done ? "done" : "stopped", config_.out);
  return done || !config_.once ? Exit::done : Exit::unfinished;
}

Status App::open() {
  auto camera = hal::open_camera(camera_backends(), config_.camera);
  if (!camera) return camera.error();
  camera_ = std::move(*camera);
  frames_expected_ = camera_->frames_expected();
  log_.line("camera {}", camera_->description());
  if (auto status = make_folder(config_.out); !status) return status;
  if (!config_.alone()) {
    const auto publish = [this](OutgoingRecord record) { radio_->publish(std::move(record)); };
    TeamMapConfig team;
    team.atlas.map = config_.mapper.map;
    team.atlas.map.budget_bytes = config_.global_budget_bytes;
    team.merge_while_mapping =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(config_.merge_while_mapping_s));
    team_ = std::make_unique<Team>(RobotId::from_name(config_.id), team, publish, log_);
    auto radio = Radio::open(
        config_, [this](auto record) { team_->apply(std::move(record)); }, log_);
    if (!radio) return radio.error();
    radio_ = std::move(*radio);
    log_.line("listening at {}, {} peers", radio_->local(), config_.peers.size());
  }
  capture_ = std::make_unique<Capture>(*camera_, config_.speed, log_);
  Publish publish;
  if (radio_) publish = [this](OutgoingRecord record) { radio_->publish(std::move(record)); };
  pipeline_ = std::make_unique<Pipeline>(config_, camera_->intrinsics(), capture_->frames(), publish, log_);
  return success();
}

void App::start() {
  if (radio_) {
    const mapping::HelloRecord hello{config_.id, config_.camera.substr(0, 200)};
    radio_->publish({mapping::Lane::control, mapping::RecordKind::hello, encode(hello)});
    team_->start();
    radio_->start();
  }
  pipeline_->start();
  capture_->start();
}

void App::stop() {
  if (!pipeline_->progress().finished) pipeline_->abandon();
  capture_->stop();
  pipeline_->join();
  if (radio_) {
    team_->stop();
    radio_->stop();
  }
  peak_rss_mb_ = daemon::peak_rss_mb();
}

bool App::work_until_done(StopSignals& signals) {
  while (!signals.wait(kTick)) {
    tick();
    if (config_.once && done()) return true;
  }
  tick();
  return capture_->ended() && pipeline_->progress().finished && (!radio_ || agreed());
}

void App::tick() {
  const Instant t = now();
  if (!finished_ && pipeline_->progress().finished) {
    finished_ = true;
    finished_at_ = t;
  }
  if (radio_) {
    // A map digest is said only when it is settled: equal digests then mean that the team is done.
    const TeamView team = team_->view();
    radio_->say(team.settled ? team.digest : 0, finished_);
    if (agreed() != agreed_) {
      agreed_ = !agreed_;
      agreed_at_ = t;
      if (agreed_) log_.line("all {} robots hold the map {:016x}", team.robots_known, team.digest);
    }
  }
  if (t - status_at_ < kStatusInterval) return;
  status_at_ = t;
  if (auto written = write_status(config_.out + "/status.json", status()); !written)
    log_.limited("status", "{}", written.error().text());
}

bool App::agreed() const {
  const TeamView team = team_->view();
  const RadioView radio = radio_->view();
  return finished_ && team.settled && radio.agrees && radio.agreed_digest == team.digest &&
         team.robots_known == radio.robots_heard;
}

bool App::peers_awaited() const {
  return radio_->view().neighbours_heard >= config_.peers.size() ||
         to_seconds(now() - finished_at_) > config_.peer_wait_s;
}

bool App::done() const {
  if (!finished_) return false;
  return !radio_ || (agreed_ && peers_awaited() && to_seconds(now() - agreed_at_) >= config_.linger_s);
}

RobotStatus App::status() const {
  RobotStatus s;
  const PipelineProgress progress = pipeline_->progress();
  s.frames = progress.frames;
  s.frames_expected = frames_expected_;
  s.tracked = progress.tracked;
  s.keyframes = progress.keyframes;
  s.robots_finished = progress.finished ? 1 : 0;
  bool settled = progress.finished;
  if (radio_) {
    const TeamView team = team_->view();
    s.map_digest = team.digest;
    s.robots_known = team.robots_known;
    s.robots_finished = team.robots_finished;
    s.robots_in_map = team.robots_in_map;
    s.frontier_digest = radio_->view().frontier_digest;
    settled = settled && team.settled;
  }
  s.agreed = radio_ ? agreed_ : settled;
  s.state = settled ? "settled" : progress.finished ? "merging" : "tracking";
  return s;
}

Report App::report() const {
  RobotReport robot;
  robot.name = config_.id;
  robot.camera = config_.camera;
  robot.frames = capture_->counters().grabbed;
  robot.tracked = pipeline_->poses().size();
  robot.keyframes = pipeline_->keyframe_poses().size();
  robot.ms_per_frame = pipeline_->frame_times().quantiles();
  robot.peak_rss_mb = peak_rss_mb_;
  Report report;
  const mapping::VoxelMap* map = &pipeline_->mapper().map();
  if (radio_) {
    const TeamView team = team_->view();
    const auto solution = team_->map().solution();
    map = team_->map().map();
    report.same_map = agreed_;
    report.merge_ms = static_cast<std::uint64_t>(to_seconds(team.merge) * 1e3);
    if (solution) {
      report.reference = solution->reference.name();
      for (const auto& solved : solution->robots) robot.in_global_map |= solved.robot == RobotId::from_name(config_.id);
    }
    robot.map_digest = team.digest;
    robot.bytes_sent = radio_->view().bytes_sent;
    robot.bytes_received = radio_->view().bytes_received;
  } else {
    report.same_map = true;
    report.reference = config_.id;
    robot.in_global_map = true;
    robot.map_digest = map->digest();
  }
  if (map) report.global_points = mapping::extract_points(*map).points.size();
  report.robots.push_back(std::move(robot));
  return report;
}

Status App::write_trajectories() const {
  if (auto status = write_text(config_.out + "/trajectory.txt", trajectory_text(pipeline_->poses())); !status)
    return status;
  if (!radio_) return success();
  const auto solution = team_->map().solution();
  if (!solution) return success();
  if (auto status = make_folder(config_.out + "/global"); !status) return status;
  for (const auto& solved : solution->robots) {
    const TeamMember& member = team_->map().members().at(solved.robot);
    const std::string file = config_.out + "/global/" + solved.robot.name() + ".txt";
    const std::string text = trajectory_text(member.poses, mapping::from_quantized(solved.T_global_robot));
    if (auto status = write_text(file, text); !status) return status;
  }
  return success();
}

MapPicture App::global_picture() const {
  MapPicture picture{config_.out + "/global", team_->map().map(), {}};
  picture.scene.title = "global map";
  std::size_t number = 0;
  const auto solution = team_->map().solution();
  for (const auto& solved : solution->robots) {
    const TeamMember& member = team_->map().members().at(solved.robot);
    picture.scene.robots.push_back(make_path(member.name, number++, member.poses, member.keyframe_poses,
                                             mapping::from_quantized(solved.T_global_robot)));
  }
  return picture;
}

std::vector<MapPicture> App::pictures() const {
  std::vector<MapPicture> pictures;
  MapPicture local{config_.out + "/local", &pipeline_->mapper().map(), {}};
  local.scene.title = "local map of " + config_.id;
  local.scene.robots.push_back(make_path(config_.id, 0, pipeline_->poses(), pipeline_->keyframe_poses()));
  pictures.push_back(std::move(local));
  if (radio_ && team_->map().solution()) pictures.push_back(global_picture());
  return pictures;
}

Status App::write_all() {
  log_.line(
      "{} frames, {:.2f} ms of processor time each (p50 {:.2f}, p99 {:.2f}); by step: {}",
      pipeline_->frame_times().count(),
      pipeline_->frame_times().total_ms() / std::max<double>(1, static_cast<double>(pipeline_->frame_times().count())),
      pipeline_->frame_times().quantile_ms(0.5), pipeline_->frame_times().quantile_ms(0.99), pipeline_->step_table());
  const CaptureCounters captured = capture_->counters();
  if (captured.dropped + captured.bad > 0)
    log_.line("{} frames dropped to keep pace, {} could not be read", captured.dropped, captured.bad);
  // The report comes last: who finds it finds everything else.
  if (auto status = write_trajectories(); !status) return status;
  if (auto status = write_pictures(pictures()); !status) return status;
  if (auto status = write_text(config_.out + "/report.json", to_json(report())); !status) return status;
  return write_status(config_.out + "/status.json", status());
}

}  // namespace onemap::daemon
