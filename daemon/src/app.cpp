#include "daemon/app.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/control/replies.hpp"
#include "daemon/heap.hpp"
#include "daemon/map_drawing.hpp"
#include "daemon/reload.hpp"
#include "hal/base/text.hpp"
#include "mapping/records/hello.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kTick = std::chrono::milliseconds(50);
constexpr auto kStatusInterval = std::chrono::milliseconds(250);
constexpr auto kHolesInterval = std::chrono::seconds(10);
constexpr auto kSayInterval = std::chrono::seconds(10);
constexpr auto kStuckPatience = std::chrono::seconds(5);
constexpr Duration kLastWords = std::chrono::seconds(2);  // for neighbours to take control and pose records at the end

constexpr Duration kQuick = std::chrono::milliseconds(300);  // for each of the above, when the end must be soon

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

void App::keep_map(const Harvest& harvest) {
  const std::uint64_t digest = team_->view().digest;
  if (kept_map_->kept() && kept_map_->kept()->digest == digest) return;
  const Status kept = guarded("settled map", [&] {
    const auto map = harvest.saved_map();
    return map ? kept_map_->keep(digest, *map, now()) : success();
  });
  if (!kept)
    log_.warn(
        "the settled map is not kept: {}; the one before stays; make room, or OUT writable, before the next start",
        kept.error().text());
}

OutgoingRecord App::greeting() const {
  mapping::HelloRecord hello{config_.id, printable(printable(config_.camera).substr(0, 180))};
  hello.map_blocks = mapping::map_parameters(global_map(config_)).blocks;
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
      log_.warn("not recording: {}; mend that, then `onemapctl record start`", begun.error().text());
  if (camera_->live()) watch_usb();
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
  radio_->settle(quick() ? kQuick : kLastWords);  // the last records are of the map, too
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

// The pipeline's thread: nobody here waits.
void App::tell_pose(const PoseNow& pose) {
  if (!pose.tracking || (!pose_streams_ && !recorder_->wants_poses())) return;
  const RecordedPose now{pose.time, pose.T_odom_camera, map_correction(team_->view(), pose)};
  recorder_->pose(now);
  if (pose_streams_) pose_streams_->say(now);
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
  hear_usb(t);
  if (!finished_ && pipeline_->progress().finished) {
    finished_ = true;
    finished_at_ = t;
  }
  take_standing(t);
  watch(t);
  snapshots_->tick(t, team_->view().digest);
  output_actions_->tick();
  map_keeper_->tick(team_->view().digest, map_agreement_.agreed(), t);
  if (t - holes_at_ >= kHolesInterval) {
    holes_at_ = t;
    give_back_holes();
  }
  if (t - status_at_ < kStatusInterval) return;
  status_at_ = t;
  const DaemonStatus s = status();
  service_.show(s, t);
  note_status(write_status(config_.out + "/status.json", s));
}

// A disk that is full or gone is no reason to end: the map is with the team, and the disk may come back.
void App::note_status(const Status& written) {
  if (!written && status_written_)
    log_.warn("{}; going on without it until that can be written: make room, or OUT writable", written.error().text());
  if (written && !status_written_) log_.line("{}/status.json is written again", config_.out);
  status_written_ = written.ok();
}

void App::watch(Instant now) {
  const std::array hearts{&capture_->heartbeat(), &pipeline_->heartbeat(), &pipeline_->publisher_heartbeat(),
                          &team_->heartbeat(), &radio_->heartbeat()};
  service_.watch(hearts, now);
}

void App::watch_usb() {
  auto usb = hal::UsbWatch::start();
  if (usb)
    usb_watch_ = std::move(*usb);
  else
    log_.line("{}", usb.error().text());
}

// What comes to USB may be the camera that is missing, on a port that is too slow for it. A plug that is loose comes
// and goes all day.
void App::hear_usb(Instant now) {
  if (!usb_watch_) return;
  for (const hal::UsbNews& one : usb_watch_->news(now)) {
    const bool good = one.problem.empty() && one.what != hal::UsbNews::What::reset;
    const std::string topic = fmt::format("{} {}", one.camera, static_cast<int>(one.what));
    log_.limited(good ? Level::info : Level::warning, topic, "{}", one.text());
  }
}

void App::take_standing(Instant now) {
  const RadioView radio = radio_->view();
  team_->presence(radio.last_sign, radio.records_complete);
  const TeamView team = team_->view();
  radio_->say(team.digest, finished_);
  radio_->bring_brightness(pipeline_->brightness());
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
    for (const std::string& peer : radio.peers_never_heard)
      log_.warn("peer {} was never heard: does it run with the same team key, is the address right?", peer);
    if (radio.left_out > 0)
      log_.warn("the map is without {} records of this robot: the store had no room; raise network.store_budget_mb",
                radio.left_out);
    const std::set<RobotId> cut_short = team_->view().cut_short;
    if (!cut_short.empty()) log_.warn("the map is without the rest of {}: silent to the end", names(cut_short));
    complete = complete && standing_.agreed && radio.peers_never_heard.empty() && radio.id_also_used_at.empty() &&
               radio.left_out == 0 && cut_short.empty();
    if (!standing_.agreed && !standing_.waiting.empty()) log_.line("{}", standing_.waiting);
  }
  log_.line("{}; everything is in {}", complete ? "done" : "unfinished", config_.out);
  return complete || !config_.once ? Exit::done : Exit::unfinished;
}

}  // namespace onemap::daemon
