#include "daemon/control/control.hpp"

#include "control/socket_place.hpp"
#include "daemon/control/metrics.hpp"
#include "daemon/control/replies.hpp"
#include "daemon/service_manager.hpp"

namespace onemap::daemon {

namespace {
constexpr std::size_t kPosesWaiting = 64, kEventsWaiting = 256;
constexpr auto kLookInterval = std::chrono::seconds(1);

// A service that nobody can ask is not up; whoever runs a daemon by hand has its map without.
bool is_service() {
  return !control::environment().runtime_directory.empty() || !ServiceManager::environment().socket.empty();
}
}  // namespace

Control::Control(EventLoop& loop, Sources sources, ControlActions actions, Log& log)
    : loop_(loop),
      sources_(std::move(sources)),
      actions_(std::move(actions)),
      log_(log),
      poses_(kPosesWaiting, [this] { pose_bell_->ring(); }),
      events_(kEventsWaiting, [this] { event_bell_->ring(); }) {}

RobotFacts Control::facts() const {
  RobotFacts facts = sources_.facts();
  if (server_) {
    facts.control = server_->counters();
    facts.control_clients = server_->clients();
  }
  facts.place.socket = place_;
  return facts;
}

Status Control::open(const Config& config, const std::string& version) {
  if (auto opened = open_feeds(); !opened) return opened;
  server_ = std::make_unique<ControlServer>(loop_, control_commands([this] { return facts(); }, actions_),
                                            greeting_json(config.id, version), log_);
  server_->on_change([this] { poses_wanted_ = server_->watches("POSE"); });
  if (auto served = serve(config); !served) return served;
  if (config.control_metrics.empty()) return success();
  auto listener = Listener::at_loopback(config.control_metrics);
  if (!listener) return Error{"control.metrics", listener.error().text()};
  log_.line("metrics at http://{}/metrics", listener->place());
  auto port = MetricsPort::open(
      loop_, std::move(*listener), [this] { return metrics_text(facts()); }, log_);
  if (!port) return port.error();
  metrics_ = std::move(*port);
  return success();
}

Status Control::serve(const Config& config) {
  const bool asked = !config.control_socket.empty();
  const std::string path =
      asked ? config.control_socket : control::default_socket(control::environment(), config.id, config.out);
  auto listener = Listener::at_path(path);
  if (!listener && asked) return Error{"control.socket", listener.error().text()};
  if (!listener && is_service())
    return Error{"no control socket", listener.error().text() +
                                          "; no service is up without: take away what is there, "
                                          "or say another place as control.socket"};
  if (!listener) {
    log_.warn("no control socket: {}; onemapctl cannot reach this robot; say control.socket", listener.error().text());
  } else {
    place_ = path;
    if (auto served = server_->serve(std::move(*listener)); !served) return served;
    log_.line("control socket {}", path);
  }
  if (config.control_tcp.empty()) return success();
  auto tcp = Listener::at_loopback(config.control_tcp);
  if (!tcp) return Error{"control.tcp", tcp.error().text()};
  log_.line("control, read-only, at {}", tcp->place());
  return server_->serve(std::move(*tcp));
}

Status Control::open_feeds() {
  auto poses = loop_.bell([this] { tell_poses(); });
  if (!poses) return poses.error();
  auto events = loop_.bell([this] { tell_events(); });
  if (!events) return events.error();
  pose_bell_ = *poses;
  event_bell_ = *events;
  const auto looks = loop_.every(kLookInterval, [this] { look(); });
  return looks ? success() : Status(looks.error());
}

void Control::close() {
  poses_wanted_ = false;
  metrics_.reset();
  server_.reset();
}

void Control::pose(const PoseNow& pose) {
  if (poses_wanted_ && pose_bell_) poses_.give(pose);
}

void Control::event(const mapping::TeamEvent& event) {
  if (event_bell_) events_.give(event_json(event));
}

void Control::tell_poses() {
  const auto poses = poses_.take();
  if (!server_) return;
  for (const PoseNow& pose : poses)
    server_->tell("POSE", [&] { return pose_json(pose, sources_.map_correction(pose)); });
}

void Control::tell_events() {
  const auto events = events_.take();
  if (!server_) return;
  for (const Json& event : events) server_->tell("EVENT", [&] { return event; });
}

void Control::look() {
  if (!server_) return;
  server_->tell("PEERS", [this] { return peers_json(facts()); });
  server_->tell("STATUS", [this] { return status_json(facts()); });
}

}  // namespace onemap::daemon
