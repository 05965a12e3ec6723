// How the app's parts are made and tied together.
#include "daemon/app.hpp"
#include "daemon/clock.hpp"
#include "daemon/control/replies.hpp"
#include "daemon/control/team_actions.hpp"
#include "daemon/map_drawing.hpp"
#include "daemon/memory_limit.hpp"
#include "mapping/records/hello.hpp"

namespace onemap::daemon {

namespace {

// Of the same copy, for whoever drives by it. A recording is played to its end, and has its plan then.
MapKeeper::Then plan_of(std::shared_ptr<const MapCopy> copy, const Config& config) {
  if (!config.refresh_plan || config.once) return {};
  return [copy = std::move(copy), &config](const std::function<bool()>& stop) -> Status {
    const auto written = write_plan({copy->log, &*copy->solution}, config.plan, {config.out + "/map"}, stop);
    return written ? success() : Status(written.error());
  };
}

MapKeeper::Take settled_map_of(Team& team, const Config& config) {
  return [take = take_from(team), &config](const std::function<bool()>& stop) -> std::optional<MapKeeper::Saved> {
    auto taken = take(stop);
    if (!taken || !taken->map || !taken->solution) return std::nullopt;
    const MapSource source{taken->log, &*taken->solution, &*taken->map};
    MapKeeper::Saved saved{taken->digest, save_global(source, "the last map of " + config.id), {}};
    taken->map.reset();  // the plan is of keyframes
    saved.then = plan_of(std::make_shared<const MapCopy>(std::move(*taken)), config);
    return saved;
  };
}
}  // namespace

Status App::open_camera() {
  auto camera = hal::open_camera(cameras_, config_.camera, wall_clock_offset());
  if (!camera) return camera.error();
  camera_ = std::move(*camera);
  if (auto status = check_camera(config_, camera_->intrinsics()); !status) return status;
  if (auto status = check_memory(config_, memory_limit(), Capture::bytes_of(camera_->intrinsics())); !status)
    return status;
  frames_expected_ = camera_->frames_expected();
  camera_facts_ = {config_.camera, camera_->description(), camera_->live(),  false,
                   false,          camera_->intrinsics(),  camera_->limits()};
  log_.line("camera {}", camera_facts_.description);
  if (!camera_facts_.limits.empty()) log_.warn("the camera {}", camera_facts_.limits);
  return success();
}

Status App::open_rest() {
  if (auto status = make_folder(config_.out); !status) return status;
  open_kept_map();
  if (auto status = open_team(); !status) return status;
  capture_ = std::make_unique<Capture>(*camera_, config_.speed, failures_, log_);
  recorder_ = std::make_unique<Recorder>(recorder_config(config_), recorded(*camera_), truth_of(config_.camera), log_);
  snapshots_ = std::make_unique<Snapshots>(config_, take_from(*team_), failures_, log_);
  map_keeper_ = std::make_unique<MapKeeper>(*kept_map_, settled_map_of(*team_, config_), failures_, log_);
  if (auto status = open_poses(); !status) return status;
  capture_->listen([this](const hal::FrameView& frame) { recorder_->offer(frame); });
  Outbox outbox;
  outbox.publish = [this](OutgoingRecord record) {
    if (config_.speed.max && record.kind == mapping::RecordKind::submap) team_->catch_up();
    radio_->publish(std::move(record));
  };
  outbox.finish = [this](std::uint32_t frames) { radio_->finish(frames); };
  outbox.next_chain = [this](std::uint32_t frames) {
    OutgoingRecord hello = greeting();
    hello.ends_life_of = frames;
    radio_->publish(std::move(hello));
  };
  pipeline_ = std::make_unique<Pipeline>(config_, *camera_, capture_->frames(), std::move(outbox), failures_, log_);
  return success();
}

Status App::open_team() {
  TeamMapConfig team;
  team.atlas = global_map(config_);
  team.merge_while_mapping = seconds(config_.merge_while_mapping_s);
  team.map_interval = seconds(config_.map_interval_s);
  team.verify.find_pairs = config_.find_pairs;
  team.places.budget_bytes = config_.places_budget_bytes;
  team.lost_after = seconds(config_.lost_after_s);
  Radio::Listener listener;
  listener.applied = [this](auto record) { team_->apply(std::move(record)); };
  listener.has_room = [this] { return team_->has_room(); };
  listener.new_life = [this](std::uint64_t incarnation, bool repeats) { team_->begin_life(incarnation, repeats); };
  auto radio = Radio::open(config_, std::move(listener), failures_, log_);
  if (!radio) return radio.error();
  radio_ = std::move(*radio);
  if (!config_.alone()) log_.line("listening at {}, {} peers", radio_->local(), config_.peers.size());
  if (const comms::DiskStore* kept = radio_->kept(); kept != nullptr)
    team.read_again = [kept](const RecordId& id) { return kept->read(id); };
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

Status App::open_loop(StopSignals& signals) {
  auto loop = EventLoop::open();
  if (!loop) return loop.error();
  loop_ = std::move(*loop);
  const auto watched = loop_->watch(signals.descriptor(), EventLoop::kReadable,
                                    [this, &signals](std::uint32_t) { take_signals(signals); });
  if (!watched) return watched.error();
  const auto ticks = loop_->every(std::chrono::milliseconds(50), [this] {
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
  OwnRecords own{[this](const auto& question, const auto& stop) { return radio_->ask(question, stop); },
                 radio_->kept()};
  output_actions_ =
      std::make_unique<OutputActions>(config_, *snapshots_, *recorder_, take_from(*team_), std::move(own));
  output_actions_->add_to(actions);
  control_ = std::make_unique<Control>(*loop_, sources, std::move(actions), log_);
  pipeline_->on_pose([this](const PoseNow& pose) {
    control_->pose(pose);
    tell_pose(pose);
  });
  team_->on_spare([this](mapping::SpareRecords records) { radio_->spare(std::move(records)); });
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

}  // namespace onemap::daemon
