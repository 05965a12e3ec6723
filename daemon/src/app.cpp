#include "daemon/app.hpp"

#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/control/replies.hpp"
#include "daemon/control/team_actions.hpp"
#include "daemon/reload.hpp"
#include "hal/base/text.hpp"
#include "mapping/records/hello.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kTick = std::chrono::milliseconds(50);
constexpr auto kStatusInterval = std::chrono::milliseconds(250);
constexpr auto kSayInterval = std::chrono::seconds(10);
constexpr auto kStuckPatience = std::chrono::seconds(5);
constexpr Duration kLastWords = std::chrono::seconds(2);  // for neighbours to take control and pose records at the end

constexpr Duration kQuick = std::chrono::milliseconds(300);  // for each of the above, when the end must be soon

Duration seconds(double s) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s)); }

PlaceFacts place_facts(const std::string& out) {
  PlaceFacts place;
  place.out = out;
  struct statvfs disk {};
  if (statvfs(out.c_str(), &disk) == 0)
    place.disk_free_bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  place.out_writable = access(out.c_str(), W_OK) == 0;
  return place;
}

MapKeeper::Take settled_map_of(Team& team, const std::string& id) {
  return [take = take_from(team), id](const std::function<bool()>& stop) -> std::optional<MapKeeper::Saved> {
    const auto copy = take(stop);
    if (!copy || !copy->map || !copy->solution) return std::nullopt;
    const MapSource source{copy->log, &*copy->solution, &*copy->map};
    return MapKeeper::Saved{copy->digest, save_global(source, "the last map of " + id)};
  };
}

std::string names(const std::set<RobotId>& robots) {
  std::string text;
  for (const RobotId& robot : robots) text += (text.empty() ? "" : ", ") + robot.name();
  return text;
}
}  // namespace

App::App(Config config, Log& log, std::span<const hal::Backend> cameras)
    : config_(std::move(config)), log_(log), cameras_(cameras), service_(log) {}

Exit App::run(StopSignals& signals) {
  for (const auto& [place, open] : std::initializer_list<std::pair<const char*, std::function<Status()>>>{
           {"camera", [this] { return open_camera(); }},
           {"start", [this] { return open_rest(); }},
           {"control", [&] { return open_loop(signals); }}})
    if (auto status = guarded(place, open); !status) return failed_to_start(status.error());
  start();
  service_.ready();
  const End end = work();
  control_->close();
  stop();
  Harvest harvest(config_, {*capture_, *pipeline_, *team_, *radio_, standing_.agreed, peak_rss_mb_}, log_);
  keep_map(harvest);
  Status written = harvest.write(quick() ? Harvest::Extent::quick : Harvest::Extent::everything);
  if (auto status = write_status(config_.out + "/status.json", this->status()); !status && written) written = status;
  return verdict(end, written);
}

Exit App::failed_to_start(const Error& error) {
  log_.error("{}", error.text());
  service_.failed(error);
  return Exit::failed;
}

void App::reload(const Result<Config>& loaded) {
  service_.reloading(now());
  if (loaded) {
    const ReloadPlan plan = plan_reload(config_, *loaded);
    apply_reload(plan, *loaded, config_);
    log_.line("configuration read again: {}", to_text(plan));
  } else {
    log_.error("{}; the configuration stays as it was", loaded.error().text());
  }
  service_.ready();
}

Status App::open_camera() {
  auto camera = hal::open_camera(cameras_, config_.camera, wall_clock_offset());
  if (!camera) return camera.error();
  camera_ = std::move(*camera);
  if (auto status = check_camera(config_, camera_->intrinsics()); !status) return status;
  frames_expected_ = camera_->frames_expected();
  camera_facts_ = {config_.camera, camera_->description(), camera_->live(), false, false, camera_->intrinsics()};
  log_.line("camera {}", camera_facts_.description);
  return success();
}

Status App::open_rest() {
  if (auto status = make_folder(config_.out); !status) return status;
  open_kept_map();
  if (auto status = open_team(); !status) return status;
  capture_ = std::make_unique<Capture>(*camera_, config_.speed, failures_, log_);
  recorder_ = std::make_unique<Recorder>(recorder_config(config_), camera_->intrinsics(), camera_->description(),
                                         truth_of(config_.camera), log_);
  snapshots_ = std::make_unique<Snapshots>(config_, take_from(*team_), failures_, log_);
  map_keeper_ = std::make_unique<MapKeeper>(*kept_map_, settled_map_of(*team_, config_.id), failures_, log_);
  if (auto status = open_poses(); !status) return status;
  capture_->listen([this](const hal::FrameView& frame) { recorder_->offer(frame); });
  Outbox outbox;
  outbox.publish = [this](OutgoingRecord record) { radio_->publish(std::move(record)); };
  outbox.finish = [this](std::uint32_t frames) { radio_->finish(frames); };
  outbox.next_chain = [this](std::uint32_t frames) {
    OutgoingRecord hello = greeting();
    hello.ends_life_of = frames;
    radio_->publish(std::move(hello));
  };
  pipeline_ = std::make_unique<Pipeline>(config_, camera_->intrinsics(), capture_->frames(), std::move(outbox),
                                         failures_, log_);
  return success();
}

Status App::open_team() {
  TeamMapConfig team;
  team.atlas.map = config_.mapper.map;
  team.atlas.map.budget_bytes = config_.global_budget_bytes;
  team.merge_while_mapping = seconds(config_.merge_while_mapping_s);
  team.map_interval = seconds(config_.map_interval_s);
  team.verify.find_pairs = config_.find_pairs;
  team.places.budget_bytes = config_.places_budget_bytes;
  team.lost_after = seconds(config_.lost_after_s);
  Radio::Listener listener;
  listener.applied = [this](auto record) { team_->apply(std::move(record)); };
  listener.new_life = [this](std::uint64_t incarnation, bool repeats) { team_->begin_life(incarnation, repeats); };
  auto radio = Radio::open(config_, std::move(listener), failures_, log_);
  if (!radio) return radio.error();
  radio_ = std::move(*radio);
  if (!config_.alone()) log_.line("listening at {}, {} peers", radio_->local(), config_.peers.size());
  const auto publish = [this](OutgoingRecord record) { radio_->publish(std::move(record)); };
  team_ = std::make_unique<Team>(RobotId::from_name(config_.id), radio_->incarnation(), team, publish, failures_, log_);
  return success();
}

// The map of an earlier life is for people: the robot finds itself in what its neighbours hold.
void App::open_kept_map() {
  kept_map_.emplace(config_.out);
  const auto kept = kept_map_->open();
  if (!kept)
    log_.warn("{}", kept.error().text());
  else if (*kept)
    log_.line("the last map of an earlier life is {}", (*kept)->file);
}

void App::keep_map(const Harvest& harvest) {
  const std::uint64_t digest = team_->view().digest;
  if (kept_map_->kept() && kept_map_->kept()->digest == digest) return;
  const Status kept = guarded("settled map", [&] {
    const auto map = harvest.saved_map();
    return map ? kept_map_->keep(digest, *map, now()) : success();
  });
  if (!kept) log_.warn("the settled map is not kept: {}; the one before stays", kept.error().text());
}

OutgoingRecord App::greeting() const {
  const mapping::HelloRecord hello{config_.id, printable(printable(config_.camera).substr(0, 180))};
  return {mapping::Lane::control, mapping::RecordKind::hello, encode(hello)};
}

void App::start() {
  radio_->publish(greeting());
  team_->start();
  radio_->start();
  pipeline_->start();
  snapshots_->start();
  map_keeper_->start();
  if (config_.record.start)
    if (auto begun = recorder_->start(next_recording(config_.out)); !begun)
      log_.warn("not recording: {}", begun.error().text());
  capture_->start();
}

void App::stop() {
  service_.stopping();
  if (!pipeline_->progress().finished) pipeline_->abandon();
  capture_->stop();
  output_actions_->stop();
  recorder_->stop();
  snapshots_->stop();
  map_keeper_->stop();
  pipeline_->join();
  if (config_.alone()) await_map();
  team_->stop(quick() ? kQuick : Team::kForTheMap);
  radio_->stop(quick() ? kQuick : kLastWords);
  peak_rss_mb_ = daemon::peak_rss_mb();
}

// Nobody else's records are missing: the map is soon there.
void App::await_map() {
  for (const Instant end = now() + (quick() ? kQuick : kLastWords);
       now() < end && !team_->view().settled && !failures_.any();)
    std::this_thread::sleep_for(kTick / 5);
  take_standing(now());
}

Status App::open_loop(StopSignals& signals) {
  auto loop = EventLoop::open();
  if (!loop) return loop.error();
  loop_ = std::move(*loop);
  const auto watched = loop_->watch(signals.descriptor(), EventLoop::kReadable,
                                    [this, &signals](std::uint32_t) { take_signals(signals); });
  if (!watched) return watched.error();
  const auto ticks = loop_->every(kTick, [this] {
    tick();
    if (failures_.any() || (config_.once && done())) loop_->stop();
  });
  return ticks ? open_control() : Status(ticks.error());
}

Status App::open_control() {
  began_ = now();
  const Control::Sources sources{[this] { return facts(); },
                                 [this](const PoseNow& pose) { return map_correction(team_->view(), pose); }};
  ControlActions actions = team_actions(*team_);
  output_actions_ = std::make_unique<OutputActions>(config_, *snapshots_, *recorder_, take_from(*team_));
  output_actions_->add_to(actions);
  control_ = std::make_unique<Control>(*loop_, sources, std::move(actions), log_);
  pipeline_->on_pose([this](const PoseNow& pose) {
    control_->pose(pose);
    tell_pose(pose);
  });
  team_->on_event([this](const mapping::TeamEvent& event) { control_->event(event); });
  return control_->open(config_, ONEMAP_VERSION);
}

Status App::open_poses() {
  if (config_.poses_socket.empty()) return success();
  auto streams = PoseStreams::open(config_.poses_socket);
  if (!streams) return streams.error();
  pose_streams_.emplace(std::move(*streams));
  return success();
}

// The pipeline's thread: nobody here waits.
void App::tell_pose(const PoseNow& pose) {
  if (!pose.tracking || (!pose_streams_ && !recorder_->wants_poses())) return;
  const RecordedPose now{pose.time, pose.T_odom_camera, map_correction(team_->view(), pose)};
  recorder_->pose(now);
  if (pose_streams_) pose_streams_->say(now);
}

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

void App::take_signals(StopSignals& signals) {
  while (const auto signal = signals.take()) {
    if (*signal == SIGHUP && reload_) {
      reload_();
      continue;
    }
    asked_to_stop_ = true;
    loop_->stop();
  }
}

App::End App::work() {
  loop_->run();
  if (failures_.any()) return End::failed;
  if (!asked_to_stop_) return End::done;
  tick();
  const bool complete = capture_->ended() && pipeline_->progress().finished && standing_.agreed;
  return complete ? End::done : End::stopped;
}

void App::tick() {
  const Instant t = now();
  if (!finished_ && pipeline_->progress().finished) {
    finished_ = true;
    finished_at_ = t;
  }
  take_standing(t);
  watch(t);
  snapshots_->tick(t, team_->view().digest);
  output_actions_->tick();
  map_keeper_->tick(team_->view().digest, map_agreement_.agreed(), t);
  if (t - status_at_ < kStatusInterval) return;
  status_at_ = t;
  const DaemonStatus s = status();
  service_.show(s, t);
  note_status(write_status(config_.out + "/status.json", s));
}

// A disk that is full or gone is no reason to end: the map is with the team, and the disk may come back.
void App::note_status(const Status& written) {
  if (!written && status_written_)
    log_.warn("{}; going on without it until that can be written", written.error().text());
  if (written && !status_written_) log_.line("{}/status.json is written again", config_.out);
  status_written_ = written.ok();
}

void App::watch(Instant now) {
  const std::array hearts{&capture_->heartbeat(), &pipeline_->heartbeat(), &team_->heartbeat(), &radio_->heartbeat()};
  service_.watch(hearts, now);
}

void App::take_standing(Instant now) {
  const RadioView radio = radio_->view();
  team_->presence(radio.last_sign, radio.records_complete);
  const TeamView team = team_->view();
  radio_->say(team.digest, finished_);
  map_agreement_.look(team, radio, now);
  radio_->leave_out(team.gone);
  const bool agreed_before = standing_.agreed, stuck_before = standing_.stuck;
  standing_ = standing(pipeline_->progress(), team, radio);
  if (standing_.stuck && !stuck_before) stuck_at_ = now;
  if (standing_.agreed && !agreed_before) {
    agreed_at_ = now;
    const std::string without = team.gone.empty() ? "" : " (without " + names(team.gone) + ", gone silent)";
    if (config_.alone())
      log_.line("the map is {:016x}", team.digest);
    else
      log_.line("all {} robots hold the map {:016x}{}", team.robots_known - team.gone.size(), team.digest, without);
  }
  say_waiting(now);
}

void App::say_waiting(Instant now) {
  if (!finished_ || standing_.waiting.empty() || now - std::max(said_at_, finished_at_) < kSayInterval) return;
  said_at_ = now;
  log_.warn("{}", standing_.waiting);
}

bool App::lingered(Instant now) const {
  if (config_.alone()) return true;
  const bool peers_heard = radio_->view().peers_never_heard.empty();
  return (peers_heard || now - finished_at_ > seconds(config_.peer_wait_s)) &&
         now - agreed_at_ >= seconds(config_.linger_s);
}

bool App::done() const {
  if (!finished_) return false;
  const Instant t = now();
  return (standing_.agreed && lingered(t)) || (standing_.stuck && t - stuck_at_ > kStuckPatience);
}

Exit App::verdict(End end, const Status& written) {
  if (failures_.any()) log_.error("failed: {}", failures_.first());
  if (failures_.any() || !written) return Exit::failed;
  if (pipeline_->progress().tracked == 0 && capture_->ended()) {
    log_.error("no frame could be placed: there is no map; onemapctl doctor says what is wrong while it runs");
    return Exit::failed;
  }
  bool complete = end == End::done;
  if (config_.once) {
    const RadioView radio = radio_->view();
    for (const std::string& peer : radio.peers_never_heard) log_.warn("peer {} was never heard", peer);
    if (radio.left_out > 0)
      log_.warn("the map is without {} records of this robot: the store had no room", radio.left_out);
    const std::set<RobotId> cut_short = team_->view().cut_short;
    if (!cut_short.empty()) log_.warn("the map is without the rest of {}: silent to the end", names(cut_short));
    complete = complete && standing_.agreed && radio.peers_never_heard.empty() && radio.id_also_used_at.empty() &&
               radio.left_out == 0 && cut_short.empty();
    if (!standing_.agreed && !standing_.waiting.empty()) log_.line("{}", standing_.waiting);
  }
  log_.line("{}; everything is in {}", complete ? "done" : "unfinished", config_.out);
  return complete || !config_.once ? Exit::done : Exit::unfinished;
}

DaemonStatus App::status() const {
  DaemonStatus s;
  const PipelineProgress progress = pipeline_->progress();
  s.frames = progress.frames;
  s.frames_expected = frames_expected_;
  s.tracked = progress.tracked;
  s.keyframes = progress.keyframes;
  s.blocks_refused = progress.blocks_refused;
  const TeamView team = team_->view();
  const RadioView radio = radio_->view();
  s.map_digest = team.digest;
  s.robots_known = team.robots_known;
  s.robots_finished = team.robots_finished;
  s.robots_in_map = team.robots_in_map;
  for (const auto& [robot, keyframes] : team.keyframes_in_map) s.keyframes_in_map[robot.name()] = keyframes;
  s.frontier_digest = radio.frontier_digest;
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
