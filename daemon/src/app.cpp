#include "daemon/app.hpp"

#include <algorithm>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/harvest.hpp"
#include "hal/base/text.hpp"
#include "mapping/records/hello.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kTick = std::chrono::milliseconds(50);
constexpr auto kStatusInterval = std::chrono::milliseconds(250);
constexpr auto kSayInterval = std::chrono::seconds(10);
constexpr auto kStuckPatience = std::chrono::seconds(5);
constexpr auto kLastWords = std::chrono::seconds(2);  // for neighbours to take control and pose records at the end

Duration seconds(double s) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s)); }

std::string names(const std::set<RobotId>& robots) {
  std::string text;
  for (const RobotId& robot : robots) text += (text.empty() ? "" : ", ") + robot.name();
  return text;
}
}  // namespace

App::App(Config config, Log& log, std::span<const hal::Backend> cameras)
    : config_(std::move(config)), log_(log), cameras_(cameras) {}

Exit App::run(StopSignals& signals) {
  if (auto status = guarded("camera", [this] { return open_camera(); }); !status) {
    log_.line("{}", status.error().text());
    return Exit::failed;
  }
  if (auto status = guarded("start", [this] { return open_rest(); }); !status) {
    log_.line("{}", status.error().text());
    return Exit::failed;
  }
  start();
  const End end = work(signals);
  stop();
  Harvest harvest(config_, {*capture_, *pipeline_, *team_, *radio_, standing_.agreed, peak_rss_mb_}, log_);
  Status written = harvest.write();
  if (auto status = write_status(config_.out + "/status.json", this->status()); !status && written) written = status;
  return verdict(end, written);
}

Status App::open_camera() {
  auto camera = hal::open_camera(cameras_, config_.camera, wall_clock_offset());
  if (!camera) return camera.error();
  camera_ = std::move(*camera);
  if (auto status = check_camera(config_, camera_->intrinsics()); !status) return status;
  frames_expected_ = camera_->frames_expected();
  log_.line("camera {}", camera_->description());
  return success();
}

Status App::open_rest() {
  if (auto status = make_folder(config_.out); !status) return status;
  if (auto status = open_team(); !status) return status;
  capture_ = std::make_unique<Capture>(*camera_, config_.speed, failures_, log_);
  recorder_ = std::make_unique<Recorder>(recorder_config(config_), camera_->intrinsics(), camera_->description(),
                                         truth_of(config_.camera), log_);
  snapshots_ = std::make_unique<Snapshots>(config_, take_from(*team_), failures_, log_);
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
  if (config_.record.start)
    if (auto begun = recorder_->start(next_recording(config_.out)); !begun)
      log_.line("not recording: {}", begun.error().text());
  capture_->start();
}

void App::stop() {
  if (!pipeline_->progress().finished) pipeline_->abandon();
  capture_->stop();
  recorder_->stop();
  snapshots_->stop();
  pipeline_->join();
  if (config_.alone()) await_map();
  team_->stop();
  radio_->stop(kLastWords);
  peak_rss_mb_ = daemon::peak_rss_mb();
}

// Nobody else's records are missing: the map is soon there.
void App::await_map() {
  for (const Instant end = now() + kLastWords; now() < end && !team_->view().settled && !failures_.any();)
    std::this_thread::sleep_for(kTick / 5);
  take_standing(now());
}

App::End App::work(StopSignals& signals) {
  while (!signals.wait(kTick)) {
    tick();
    if (failures_.any()) return End::failed;
    if (config_.once && done()) return End::done;
  }
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
  snapshots_->tick(t, team_->view().digest);
  if (t - status_at_ < kStatusInterval) return;
  status_at_ = t;
  note_status(write_status(config_.out + "/status.json", status()));
}

// A disk that is full or gone is no reason to end: the map is with the team, and the disk may come back.
void App::note_status(const Status& written) {
  if (!written && status_written_)
    log_.line("{}; going on without it until that can be written", written.error().text());
  if (written && !status_written_) log_.line("{}/status.json is written again", config_.out);
  status_written_ = written.ok();
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
  log_.line("{}", standing_.waiting);
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
  if (failures_.any()) log_.line("failed: {}", failures_.first());
  if (failures_.any() || !written) return Exit::failed;
  if (pipeline_->progress().tracked == 0 && capture_->ended()) {
    log_.line("no frame could be placed: there is no map");
    return Exit::failed;
  }
  bool complete = end == End::done;
  if (config_.once) {
    const RadioView radio = radio_->view();
    for (const std::string& peer : radio.peers_never_heard) log_.line("peer {} was never heard", peer);
    if (radio.left_out > 0)
      log_.line("the map is without {} records of this robot: the store had no room", radio.left_out);
    const std::set<RobotId> cut_short = team_->view().cut_short;
    if (!cut_short.empty()) log_.line("the map is without the rest of {}: silent to the end", names(cut_short));
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
  if (team.T_map_odometry && team.chain == pose.chain)
    s.T_map_odom = mapping::from_quantized(*team.T_map_odometry) * pose.T_odom_robot.inverse();
  s.state = progress.finished && team.settled ? "settled" : progress.finished ? "merging" : "tracking";
  return s;
}

}  // namespace onemap::daemon
