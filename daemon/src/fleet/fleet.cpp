#include "daemon/fleet/fleet.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "daemon/clock.hpp"
#include "daemon/outputs.hpp"
#include "hal/backends/simulated.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kPoll = std::chrono::milliseconds(200);
constexpr auto kPatience = std::chrono::seconds(120);  // for the last pictures of many robots on a small machine
constexpr const char* kStay = "1000000";               // --linger: the fleet says when
}  // namespace

Fleet::Fleet(FleetConfig config, std::string daemon_program)
    : config_(std::move(config)), daemon_program_(std::move(daemon_program)), statuses_(config_.cameras.size()) {}

Exit Fleet::run(StopSignals& signals) {
  if (auto status = start(); !status) {
    fmt::print(stderr, "onemap-fleet: {}\n", status.error().text());
    return Exit::failed;
  }
  const End end = wait_until_agreed(signals);
  if (end == End::out_of_time) fmt::print(stderr, "onemap-fleet: not agreed after {} s\n", config_.timeout_s);
  const bool robots_done = stop_robots();
  auto report = collect();
  if (!report) {
    fmt::print(stderr, "onemap-fleet: {}\n", report.error().text());
    return Exit::failed;
  }
  if (auto status = write_text(config_.out + "/report.json", to_json(*report)); !status) {
    fmt::print(stderr, "onemap-fleet: {}\n", status.error().text());
    return Exit::failed;
  }
  print_result(*report);
  if (end == End::robot_ended) return Exit::failed;
  if (end != End::agreed || !report->same_map) return Exit::unfinished;
  return robots_done ? Exit::done : Exit::failed;
}

Status Fleet::start() {
  auto links = LinkEmulator::open(config_.links, config_.faults);
  if (!links) return links.error();
  links_ = std::move(*links);
  for (std::size_t i = 0; i < config_.cameras.size(); ++i) {
    if (auto status = make_folder(folder(i)); !status) return status;
    if (auto status = write_truth(i); !status) return status;
    for (const char* old : {"/status.json", "/report.json"}) {  // of an earlier run: they would be taken for news
      std::error_code none;
      std::filesystem::remove(folder(i) + old, none);
    }
  }
  for (std::size_t i = 0; i < config_.cameras.size(); ++i)
    if (auto status = start_robot(i); !status) return status;
  links_->start();  // after the forks: a child has no half-copied thread
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
  if (!config_.robot_config.empty()) arguments.insert(arguments.end(), {"--config", config_.robot_config});
  auto child = ChildProcess::start(daemon_program_, arguments, folder(number) + "/log.txt");
  if (!child) return child.error();
  robots_.push_back(std::move(*child));
  return success();
}

Fleet::End Fleet::wait_until_agreed(StopSignals& signals) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < robots_.size(); ++i) names.push_back(fleet_robot_name(i));
  Progress progress(names, isatty(STDERR_FILENO) == 1);
  const Instant limit = now() + std::chrono::milliseconds(static_cast<std::int64_t>(config_.timeout_s * 1e3));
  for (;;) {
    const bool stopped = signals.wait(kPoll);
    read_statuses();
    const bool agreed = all_agree();
    progress.show(statuses_, now(), agreed);
    if (agreed) return End::agreed;
    if (stopped) return End::stopped;
    if (now() >= limit) return End::out_of_time;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (robots_[i].running()) continue;
      fmt::print(stderr, "onemap-fleet: {} ended too early with {}; see {}/log.txt\n", fleet_robot_name(i),
                 robots_[i].exit_text(), folder(i));
      return End::robot_ended;
    }
  }
}

void Fleet::read_statuses() {
  for (std::size_t i = 0; i < statuses_.size(); ++i)
    if (auto status = read_status(folder(i) + "/status.json")) statuses_[i] = std::move(*status);
}

bool Fleet::all_agree() const {
  // Robots without a way to each other agree among those that they know; the report then says whether maps are equal.
  return std::ranges::all_of(statuses_, [](const RobotStatus& s) { return s.agreed && s.state == "settled"; }) &&
         std::ranges::all_of(statuses_, [&](const RobotStatus& s) {
           return s.robots_known == statuses_.size() && s.map_digest == statuses_[0].map_digest;
         });
}

bool Fleet::stop_robots() {
  for (ChildProcess& robot : robots_) robot.terminate();
  const Instant limit = now() + kPatience;
  bool good = true;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (!robots_[i].wait(std::max(Duration::zero(), limit - now()))) {
      fmt::print(stderr, "onemap-fleet: {} does not stop; ending it\n", fleet_robot_name(i));
      good = false;
    } else if (robots_[i].exit_code() != 0) {
      fmt::print(stderr, "onemap-fleet: {}: {}; see {}/log.txt\n", fleet_robot_name(i), robots_[i].exit_text(),
                 folder(i));
      good = false;
    }
  }
  links_->stop();
  return good;
}

Result<Report> Fleet::collect() const {
  std::vector<Report> reports;
  for (std::size_t i = 0; i < config_.cameras.size(); ++i) {
    auto report = read_report(folder(i) + "/report.json");
    if (!report) return report.error();
    reports.push_back(std::move(*report));
  }
  return join_reports(reports, all_agree());
}

Report join_reports(const std::vector<Report>& robots, bool all_agreed) {
  Report team;
  team.same_map = all_agreed && !robots.empty();
  for (const Report& robot : robots) {
    team.robots.insert(team.robots.end(), robot.robots.begin(), robot.robots.end());
    team.merge_ms = std::max(team.merge_ms, robot.merge_ms);
    team.same_map = team.same_map && robot.reference == robots.front().reference &&
                    robot.global_points == robots.front().global_points;
  }
  if (robots.empty()) return team;
  team.reference = robots.front().reference;
  team.global_points = robots.front().global_points;
  for (const RobotReport& robot : team.robots)
    team.same_map = team.same_map && robot.map_digest == team.robots.front().map_digest;
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
  return write_text(folder(number) + "/groundtruth.txt", text);
}

void Fleet::print_result(const Report& report) const {
  fmt::print("{}\n", to_table(report));
  fmt::print("maps equal: {}; reference {}; merged in {} ms; {} points\n", report.same_map ? "yes" : "NO",
             report.reference, report.merge_ms, report.global_points);
  fmt::print("pictures:\n");
  for (std::size_t i = 0; i < config_.cameras.size(); ++i) fmt::print("  {0}/local.png  {0}/global.png\n", folder(i));
  fmt::print("models (glTF and PLY):\n");
  for (std::size_t i = 0; i < config_.cameras.size(); ++i)
    fmt::print("  {0}/local.glb  {0}/global.glb  {0}/local.ply  {0}/global.ply\n", folder(i));
  fmt::print("report: {}/report.json\n", config_.out);
}

}  // namespace onemap::daemon
