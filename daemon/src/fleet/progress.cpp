#include "daemon/fleet/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace onemap::daemon {

namespace {
constexpr std::size_t kBarWidth = 30;
constexpr auto kLineInterval = std::chrono::seconds(5);

std::uint64_t percent(const DaemonStatus& robot) {
  return robot.frames_expected == 0 ? 0 : std::min<std::uint64_t>(100, 100 * robot.frames / robot.frames_expected);
}
}  // namespace

std::string Progress::bar(const std::string& name, const DaemonStatus& robot) {
  const std::size_t filled = percent(robot) * kBarWidth / 100;
  return fmt::format("{:<8} [{}{}] {:>3} %  {}/{} frames, {} tracked, {} keyframes, {}", name, std::string(filled, '#'),
                     std::string(kBarWidth - filled, '-'), percent(robot), robot.frames, robot.frames_expected,
                     robot.tracked, robot.keyframes, robot.agreed ? "agreed" : robot.state);
}

void Progress::show(const std::vector<DaemonStatus>& robots, Instant now, bool last) {
  if (terminal_) return redraw(robots);
  if (!last && drawn_ && now - shown_ < kLineInterval) return;
  drawn_ = true;
  shown_ = now;
  print_line(robots);
}

void Progress::redraw(const std::vector<DaemonStatus>& robots) {
  if (drawn_) fmt::print(stderr, "\x1b[{}A", robots.size());  // up over the bars of the last time
  drawn_ = true;
  for (std::size_t i = 0; i < robots.size(); ++i) fmt::print(stderr, "\x1b[2K{}\n", bar(names_[i], robots[i]));
}

void Progress::print_line(const std::vector<DaemonStatus>& robots) const {
  std::string text;
  for (std::size_t i = 0; i < robots.size(); ++i)
    text += fmt::format("{}{} {} {} % ({} keyframes)", i == 0 ? "" : ", ", names_[i],
                        robots[i].agreed ? "agreed" : robots[i].state, percent(robots[i]), robots[i].keyframes);
  fmt::print(stderr, "{}\n", text);
}

}  // namespace onemap::daemon
