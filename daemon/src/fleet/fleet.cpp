#include "daemon/fleet/fleet.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "daemon/clock.hpp"
#include "daemon/command_line.hpp"
#include "daemon/fleet/log_tail.hpp"
#include "daemon/outputs.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kPoll = std::chrono::milliseconds(200);
constexpr auto kPatience = std::chrono::seconds(120);  // for the last pictures of many robots on a small machine
constexpr const char* kStay = "1000000";               // --linger: the fleet says when
constexpr std::size_t kLogLines = 5;                   // of a robot that failed

void say(const std::string& what) { std::fputs(complaint("onemap-fleet", what).c_str(), stderr); }

bool is_unfinished(int exit_code) { return exit_code == static_cast<int>(Exit::unfinished); }
}  // namespace

Fleet::Fleet(FleetConfig config, std::string daemon_program)
    : config_(std::move(config)), daemon_program_(std::move(daemon_program)), statuses_(config_.cameras.size()) {}

Exit Fleet::run(StopSignals& signals) {
  if (auto status = start(); !status) {
    say(status.error().text());
    return Exit::failed;
  }
  const End end = wait_until_agreed(signals);
  if (end == End::out_of_time) {
    say(fmt::format("not agreed after {} s", config_.timeout_s));
    for (std::size_t i = 0; i < statuses_.size(); ++i)
      if (!statuses_[i].waiting.empty()) say(fleet_robot_name(i) + ": " + statuses_[i].waiting);
  }
  if (end == End::stopped) say("stopped before all agreed");
  stop_robots();
  const Report report = collect(end == End::agreed);
  const Status written = write_text_file(config_.out + "/report.json", to_json(report));
  fmt::print("{}", to_text(report, config_.out));
  if (!written) say(written.error().text());
  return written ? verdict(end, report) : Exit::failed;
}

Exit Fleet::verdict(End end, const Report& report) const {
  const auto code = [](const Robot& robot) { return robot.process.exit_code(); };
  for (const Robot& robot : robots_)
    if (code(robot) != 0 && !is_unfinished(code(robot))) return Exit::failed;
  const bool done = std::ranges::all_of(robots_, [&](const Robot& robot) { return code(robot) == 0; });
  return end == End::agreed && report.same_map && done ? Exit::done : Exit::unfinished;
}

Status Fleet::start() {
  auto links = LinkEmulator::open(config_.links, config_.faults);
  if (!links) return links.error();
  links_ = std::move(*links);
  for (std::size_t i = 0; i < config_.cameras.size(); ++i) {
    if (auto status = make_folder(folder(i)); !status) return status;
    if (auto status = clear_folder(i); !status) return status;
    if (auto status = write_truth(i); !status) return status;
  }
  for (std::size_t i = 0; i < config_.cameras.size(); ++i)
    if (auto status = start_robot(i); !status) return status;
  links_->start();  // after the forks: a child has no half-copied thread
  return success();
}

// What an earlier run left would be taken for this one's.
Status Fleet::clear_folder(std::size_t number) const {
  for (const char* name : {"status.json", "report.json", "trajectory.txt", "local.png", "local.glb", "local.ply",
                           "local.pcd", "global.png", "global.glb", "global.ply", "global.pcd", "team.png", "map.pgm",
                           "map.yaml", "graph.g2o", "matches"}) {
    std::error_code error;
    const std::string file = folder(number) + "/" + name;
    std::filesystem::remove_all(file, error);
    if (error) return Error{file, "of an earlier run, cannot be removed: " + error.message()};
  }
  return success();
}

Status Fleet::start_robot(std::size_t number) {
  std::vector<std::string> arguments{"--camera",    config_.cameras[number],
                                     "--id",        fleet_robot_name(number),
                                     "--listen",    "127.0.0.1:0",
                                     "--once",      "--linger",
                                     kStay,         "--speed",
                                     config_.speed, "--out",
                                     folder(number)};
  for (std::size_t link = 0; link < config_.links.size(); ++link) {
    if (config_.links[link].first != number && config_.links[link].second != number) continue;
    arguments.insert(arguments.end(), {"--peer", fmt::format("127.0.0.1:{}", links_->port(link, number))});
  }
  if (!config_.features.empty()) arguments.insert(arguments.end(), {"--features", config_.features});
  if (config_.matches_picture > 0)
    arguments.insert(arguments.end(), {"--matches-picture", std::to_string(config_.matches_picture)});
  arguments.insert(arguments.end(), {"--team-key", config_.team_key.empty() ? "none" : config_.team_key});
  // Not the one of a robot that this machine may be.
  arguments.insert(arguments.end(), {"--config", config_.robot_config.empty() ? "/dev/null" : config_.robot_config});
  auto child = ChildProcess::start(daemon_program_, arguments, folder(number) + "/log.txt");
  if (!child) return child.error();
  robots_.push_back({std::move(*child), {}});
  return success();
}

Fleet::End Fleet::wait_until_agreed(StopSignals& signals) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < robots_.size(); ++i) names.push_back(fleet_robot_name(i));
  Progress progress(names, isatty(STDERR_FILENO) == 1, now());
  const Instant limit = now() + std::chrono::milliseconds(static_cast<std::int64_t>(config_.timeout_s * 1e3));
  for (;;) {
    const bool stopped = signals.wait(kPoll);
    read_statuses();
    const bool agreed = all_agree();
    progress.show(statuses_, now(), agreed);
    if (agreed) return End::agreed;
    if (stopped) return End::stopped;
    if (now() >= limit) return End::out_of_time;
    if (any_ended()) return End::robot_ended;
  }
}

bool Fleet::any_ended() {
  bool any = false;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i].process.running()) continue;
    any = true;
    robots_[i].failed = "ended too early with " + robots_[i].process.exit_text();
    say_failed(i);
  }
  return any;
}

void Fleet::say_failed(std::size_t number) const {
  const std::string log = folder(number) + "/log.txt";
  say(fmt::format("{} {}; the end of {}:", fleet_robot_name(number), robots_[number].failed, log));
  for (const std::string& line : last_lines(log, kLogLines)) fmt::print(stderr, "  {}\n", line);
}

void Fleet::read_statuses() {
  for (std::size_t i = 0; i < statuses_.size(); ++i)
    if (auto status = read_status(folder(i) + "/status.json")) statuses_[i] = std::move(*status);
}

bool Fleet::all_agree() const {
  // Robots without a way to each other agree among those that they know; the report then says whether maps are equal.
  return std::ranges::all_of(statuses_, [](const DaemonStatus& s) { return s.agreed && s.state == "settled"; }) &&
         std::ranges::all_of(statuses_, [&](const DaemonStatus& s) {
           return s.robots_known == statuses_.size() && s.map_digest == statuses_[0].map_digest;
         });
}

void Fleet::stop_robots() {
  for (Robot& robot : robots_) robot.process.terminate();
  const Instant limit = now() + kPatience;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    auto& [process, failed] = robots_[i];
    if (!failed.empty()) continue;
    if (!process.wait(std::max(Duration::zero(), limit - now()))) {
      process.kill();
      failed = fmt::format("did not stop within {} s", kPatience.count());
    } else if (process.exit_code() != 0 && !is_unfinished(process.exit_code())) {
      failed = "ended with " + process.exit_text();
    }
    if (!failed.empty()) say_failed(i);
  }
  links_->stop();
  read_statuses();
}

Report Fleet::collect(bool agreed) const {
  std::vector<Report> reports;
  for (std::size_t i = 0; i < config_.cameras.size(); ++i) reports.push_back(robot_report(i));
  return join_reports(reports, agreed);
}

// What the robot wrote, or what was last known of it.
Report Fleet::robot_report(std::size_t number) const {
  const std::string& failed = robots_[number].failed;
  if (auto report = read_report(folder(number) + "/report.json"); report && report->robots.size() == 1) {
    report->robots[0].name = fleet_robot_name(number);  // whatever it says: paths are made of it
    report->robots[0].failed = failed;
    return *report;
  }
  const DaemonStatus& status = statuses_[number];
  RobotReport robot;
  robot.name = fleet_robot_name(number);
  robot.camera = config_.cameras[number];
  robot.frames = status.frames;
  robot.tracked = status.tracked;
  robot.keyframes = status.keyframes;
  robot.blocks_refused = status.blocks_refused;
  robot.refused = status.refused;
  robot.failed = failed.empty() ? "wrote no report" : failed;
  Report report;
  report.robots.push_back(std::move(robot));
  return report;
}

Report join_reports(const std::vector<Report>& robots, bool all_agreed) {
  Report team;
  team.same_map = all_agreed && !robots.empty();
  for (const Report& robot : robots) {
    if (team.reference.empty()) {
      team.reference = robot.reference;
      team.global_points = robot.global_points;
      team.merges = robot.merges;
    }
    team.robots.insert(team.robots.end(), robot.robots.begin(), robot.robots.end());
    team.merge_ms = std::max(team.merge_ms, robot.merge_ms);
    team.same_map = team.same_map && robot.reference == robots.front().reference &&
                    robot.global_points == robots.front().global_points;
  }
  for (const RobotReport& robot : team.robots)
    team.same_map = team.same_map && robot.failed.empty() && robot.map_digest == team.robots.front().map_digest;
  return team;
}

Status Fleet::write_truth(std::size_t number) const {
  auto address = hal::parse_camera_address(config_.cameras[number]);
  if (!address || address->backend != "simulated") return success();  // recordings bring their own
  auto truth = hal::simulated_truth(*address);
  if (!truth) return truth.error();
  std::string text;
  for (const hal::SimulatedPose& pose : *truth) {
    const std::int64_t us = pose.time.time_since_epoch().count() / 1000;
    const auto& t = pose.t_world_camera_m;
    const auto& q = pose.q_world_camera_xyzw;
    text += fmt::format("{}.{:06} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", us / 1000000, us % 1000000, t[0],
                        t[1], t[2], q[0], q[1], q[2], q[3]);
  }
  return write_text_file(folder(number) + "/groundtruth.txt", text);
}

namespace {

// Those of the files that are there, a robot's on a line of its own, or on several.
std::string list_files(const Report& report, const std::string& out, const std::string& title,
                       std::initializer_list<const char*> names) {
  std::string text;
  for (const RobotReport& robot : report.robots) {
    std::string line;
    for (const char* name : names) {
      std::error_code none;
      const std::string file = out + "/" + robot.name + "/" + name;
      if (!std::filesystem::is_regular_file(file, none)) continue;
      const std::string word = "  " + printable(file);
      if (!line.empty() && line.size() + word.size() > Progress::kColumns) text += std::exchange(line, {}) + "\n";
      line += word;
    }
    if (!line.empty()) text += line + "\n";
  }
  return text.empty() ? text : title + "\n" + text;
}

}  // namespace

std::string to_text(const Report& report, const std::string& out) {
  const std::string merges = to_table(report.merges);
  return to_table(report) + (merges.empty() ? "" : "\n" + merges) +
         fmt::format("\nmaps equal: {}; reference {}; merged in {} ms; {} points\n", report.same_map ? "yes" : "NO",
                     report.reference.empty() ? "none" : report.reference, report.merge_ms, report.global_points) +
         list_files(report, out, "pictures:", {"local.png", "global.png", "team.png"}) +
         list_files(report, out, "models (glTF, PLY, PCD):",
                    {"local.glb", "global.glb", "local.ply", "global.ply", "local.pcd", "global.pcd"}) +
         list_files(report, out, "floor plans (for map_server):", {"map.yaml"}) + "report: " + printable(out) +
         "/report.json\n";
}

}  // namespace onemap::daemon
