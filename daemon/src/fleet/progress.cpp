#include "daemon/fleet/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace onemap::daemon {

namespace {
constexpr std::size_t kBarWidth = 40;
constexpr auto kLineInterval = std::chrono::seconds(5);
constexpr auto kSettleIn = std::chrono::seconds(3);  // no guess of the time that is left before
constexpr const char *kGreen = "\x1b[32m", *kYellow = "\x1b[33m", *kPlain = "\x1b[0m";

std::uint64_t percent(std::uint64_t done, std::uint64_t of) {
  return of == 0 ? 0 : std::min<std::uint64_t>(100, 100 * done / of);
}

// Of the frames, which take nearly all of the time.
struct Share {
  std::uint64_t done = 0, of = 0;
  explicit Share(const std::vector<DaemonStatus>& robots) {
    for (const DaemonStatus& robot : robots) {
      done += std::min(robot.frames, robot.frames_expected);
      of += robot.frames_expected;
    }
  }
};

std::string span(Duration time) {
  const auto s = std::chrono::duration_cast<std::chrono::seconds>(time).count();
  return s < 60 ? fmt::format("{} s", s) : fmt::format("{} min {} s", s / 60, s % 60);
}

// NO_COLOR: see no-color.org.
bool wants_color() {
  const char* no = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe): nobody sets variables
  return no == nullptr || *no == '\0';
}
}  // namespace

Progress::Progress(std::vector<std::string> names, bool terminal, Instant started)
    : names_(std::move(names)), terminal_(terminal), colored_(terminal && wants_color()), started_(started) {}

std::string Progress::line(const std::string& name, const DaemonStatus& robot, bool colored) {
  const std::string state = robot.agreed ? "agreed" : robot.state;
  const std::string text = fmt::format("{:<8} {:>7}/{} frames  {:>7} tracked  {:>5} keyframes  ", name, robot.frames,
                                       robot.frames_expected, robot.tracked, robot.keyframes);
  return colored ? text + (robot.agreed ? kGreen : kYellow) + state + kPlain : text + state;
}

std::string Progress::bar(const std::vector<DaemonStatus>& robots, Duration elapsed) {
  const Share share(robots);
  const std::uint64_t part = percent(share.done, share.of);
  const std::size_t filled = part * kBarWidth / 100;
  std::string left;
  if (share.of > 0 && share.done == share.of)
    left = "agreeing on the map";
  else if (elapsed >= kSettleIn && share.done > 0)
    left = "about " +
           span(elapsed * static_cast<std::int64_t>(share.of - share.done) / static_cast<std::int64_t>(share.done)) +
           " left";
  return fmt::format("{:<8} [{}{}] {:>3} %  {}", "team", std::string(filled, '#'), std::string(kBarWidth - filled, '-'),
                     part, left);
}

void Progress::show(const std::vector<DaemonStatus>& robots, Instant now, bool last) {
  if (terminal_) return redraw(robots, now - started_);
  if (!last && drawn_ && now - shown_ < kLineInterval) return;
  drawn_ = true;
  shown_ = now;
  print_line(robots);
}

void Progress::redraw(const std::vector<DaemonStatus>& robots, Duration elapsed) {
  if (drawn_) fmt::print(stderr, "\x1b[{}A", robots.size() + 1);  // up over the lines of the last time
  drawn_ = true;
  for (std::size_t i = 0; i < robots.size(); ++i)
    fmt::print(stderr, "\x1b[2K{}\n", line(names_[i], robots[i], colored_));
  fmt::print(stderr, "\x1b[2K{}\n", bar(robots, elapsed));
}

void Progress::print_line(const std::vector<DaemonStatus>& robots) const {
  std::string row;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const std::string part =
        fmt::format("{} {} {} % ({} keyframes)", names_[i], robots[i].agreed ? "agreed" : robots[i].state,
                    percent(robots[i].frames, robots[i].frames_expected), robots[i].keyframes);
    if (!row.empty() && row.size() + 2 + part.size() > kColumns) {
      fmt::print(stderr, "{}\n", row);
      row.clear();
    }
    row += (row.empty() ? "" : ", ") + part;
  }
  fmt::print(stderr, "{}\n", row);
}

}  // namespace onemap::daemon
