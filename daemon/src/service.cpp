#include "daemon/service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace onemap::daemon {

namespace {

constexpr auto kShowInterval = std::chrono::seconds(1);
constexpr auto kStoppedAfter = std::chrono::seconds(2);  // without a look, of which there are twenty a second

std::string map_words(const DaemonStatus& s) {
  if (s.map_digest == 0) return "no map yet";
  const std::string map =
      fmt::format("{} of {} robots in the map {:016x}", s.robots_in_map, s.robots_known, s.map_digest);
  if (s.map_agreed) return map + ", held by all";
  std::string differing;
  for (const std::string& robot : s.map_differs) differing += (differing.empty() ? "" : ", ") + robot;
  return differing.empty() ? map : map + ", not yet held by " + differing;
}

}  // namespace

std::string status_line(const DaemonStatus& s) {
  const std::string state = s.state == "tracking" && !s.tracking ? "lost" : s.state;
  std::string text = fmt::format("{}: {} of {} frames placed, {} keyframes; {}", state, s.tracked, s.frames,
                                 s.keyframes, map_words(s));
  if (s.stuck && !s.waiting.empty()) text += "; " + s.waiting;
  return text;
}

void Service::note(const Status& status) {
  if (!status) log_.limited("service manager", "{}", status.error().text());
}

void Service::show(const DaemonStatus& status, Instant now) {
  if (!manager_.present() || now - shown_at_ < kShowInterval) return;
  std::string line = status_line(status);
  if (line == shown_) return;
  shown_at_ = now;
  shown_ = std::move(line);
  note(manager_.say(shown_));
}

void Service::watch(std::span<const Heartbeat* const> hearts, Instant now) {
  if (now - std::exchange(looked_at_, now) > kStoppedAfter) awake_since_ = now;
  const auto stuck = std::ranges::find_if(
      hearts, [&](const Heartbeat* heart) { return heart->stuck(now) && now - awake_since_ > heart->patience(); });
  say_stuck(stuck == hearts.end() ? nullptr : *stuck);
  if (stuck_ || !manager_.watchdog() || now - fed_at_ < *manager_.watchdog() / 4) return;
  fed_at_ = now;
  note(manager_.alive());
}

void Service::say_stuck(const Heartbeat* stuck) {
  if (stuck == stuck_) return;
  stuck_ = stuck;
  if (stuck_ == nullptr) return log_.line("all threads get on again");
  log_.error("the {} thread has not got on for {:.0f} s{}", stuck_->name(), to_seconds(stuck_->patience()),
             manager_.watchdog() ? ": the watchdog is not fed, and the service will be started again" : "");
}

}  // namespace onemap::daemon
