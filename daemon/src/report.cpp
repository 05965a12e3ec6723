#include "daemon/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using Json = nlohmann::ordered_json;

namespace {

double rounded(double value) { return std::round(value * 100) / 100; }

Json to_object(const RobotReport& robot) {
  const Quantiles& ms = robot.ms_per_frame;
  Json object{{"name", robot.name},
              {"camera", printable(robot.camera)},
              {"frames", robot.frames},
              {"tracked", robot.tracked},
              {"keyframes", robot.keyframes},
              {"in_global_map", robot.in_global_map},
              {"map_digest", digest_text(robot.map_digest)},
              {"ms_per_frame", {{"p50", rounded(ms.p50_ms)}, {"p95", rounded(ms.p95_ms)}, {"p99", rounded(ms.p99_ms)}}},
              {"peak_rss_mb", rounded(robot.peak_rss_mb)},
              {"bytes_sent", robot.bytes_sent},
              {"bytes_received", robot.bytes_received},
              {"blocks_refused", robot.blocks_refused},
              {"plan_squares", robot.plan_squares},
              {"plan_votes_refused", robot.plan_votes_refused},
              {"refused", robot.refused}};
  if (!robot.failed.empty()) object["failed"] = printable(robot.failed);
  return object;
}

RobotReport robot_from(const Json& object) {
  RobotReport robot;
  object.at("name").get_to(robot.name);
  object.at("camera").get_to(robot.camera);
  object.at("frames").get_to(robot.frames);
  object.at("tracked").get_to(robot.tracked);
  object.at("keyframes").get_to(robot.keyframes);
  object.at("in_global_map").get_to(robot.in_global_map);
  const auto digest = object.at("map_digest").get<std::string>();
  std::from_chars(digest.data(), digest.data() + digest.size(), robot.map_digest, 16);
  const Json& ms = object.at("ms_per_frame");
  robot.ms_per_frame = {ms.at("p50"), ms.at("p95"), ms.at("p99")};
  object.at("peak_rss_mb").get_to(robot.peak_rss_mb);
  object.at("bytes_sent").get_to(robot.bytes_sent);
  object.at("bytes_received").get_to(robot.bytes_received);
  robot.blocks_refused = object.value("blocks_refused", robot.blocks_refused);
  robot.plan_squares = object.value("plan_squares", robot.plan_squares);
  robot.plan_votes_refused = object.value("plan_votes_refused", robot.plan_votes_refused);
  robot.refused = object.value("refused", robot.refused);
  robot.failed = object.value("failed", robot.failed);
  return robot;
}

Json to_object(const Merge& merge) {
  Json object{{"a", merge.a},
              {"b", merge.b},
              {"joined", merge.refused.empty()},
              {"cloud_a", merge.cloud_a},
              {"cloud_b", merge.cloud_b},
              {"pairs", merge.pairs},
              {"inliers", merge.inliers},
              {"ratio", rounded(merge.ratio)},
              {"error_mm", rounded(merge.error_mm)},
              {"distance_m", rounded(merge.distance_m)},
              {"turn_deg", rounded(merge.turn_deg)}};
  if (!merge.refused.empty()) object["refused"] = merge.refused;
  return object;
}

Merge merge_from(const Json& object) {
  Merge merge;
  object.at("a").get_to(merge.a);
  object.at("b").get_to(merge.b);
  merge.refused = object.value("refused", std::string());
  object.at("cloud_a").get_to(merge.cloud_a);
  object.at("cloud_b").get_to(merge.cloud_b);
  object.at("pairs").get_to(merge.pairs);
  object.at("inliers").get_to(merge.inliers);
  object.at("ratio").get_to(merge.ratio);
  object.at("error_mm").get_to(merge.error_mm);
  object.at("distance_m").get_to(merge.distance_m);
  object.at("turn_deg").get_to(merge.turn_deg);
  return merge;
}

}  // namespace

std::string digest_text(std::uint64_t digest) { return fmt::format("{:016x}", digest); }

std::string to_json(const Report& report) {
  Json robots = Json::array();
  for (const RobotReport& robot : report.robots) robots.push_back(to_object(robot));
  Json object{{"same_map", report.same_map},
              {"reference", report.reference},
              {"merge_ms", report.merge_ms},
              {"global_points", report.global_points},
              {"robots", robots}};
  for (const Merge& merge : report.merges) object["merges"].push_back(to_object(merge));
  return object.dump(2) + "\n";
}

Result<Report> report_from_json(const std::string& text, const std::string& place) {
  try {
    const Json object = Json::parse(text);
    Report report;
    object.at("same_map").get_to(report.same_map);
    object.at("reference").get_to(report.reference);
    object.at("merge_ms").get_to(report.merge_ms);
    object.at("global_points").get_to(report.global_points);
    for (const Json& robot : object.at("robots")) report.robots.push_back(robot_from(robot));
    if (object.contains("merges"))
      for (const Json& merge : object["merges"]) report.merges.push_back(merge_from(merge));
    return report;
  } catch (const Json::exception& error) {
    return Error{place, error.what()};
  }
}

Result<Report> read_report(const std::string& file) {
  const auto text = read_text_file(file);
  return text ? report_from_json(*text, file) : text.error();
}

namespace {

std::string troubles(const RobotReport& robot) {
  std::string text;
  if (!robot.failed.empty()) text += fmt::format("{}: FAILED: {}\n", robot.name, printable(robot.failed));
  if (robot.blocks_refused > 0)
    text += fmt::format("{}: no room for {} blocks of the local map, which are missing: raise map.budget_mb\n",
                        robot.name, robot.blocks_refused);
  if (robot.plan_votes_refused > 0)
    text += fmt::format("{}: no room for all of the floor plan's free space: raise map.plan_budget_mb\n", robot.name);
  std::string reasons;
  for (const auto& [reason, count] : robot.refused)
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", printable(reason), count);
  if (!reasons.empty()) text += fmt::format("{}: refused from the network: {}\n", robot.name, reasons);
  return text;
}

}  // namespace

std::string to_table(const Report& report) {
  std::size_t width = 5;
  for (const RobotReport& robot : report.robots) width = std::max(width, robot.name.size());
  std::string text = fmt::format("{:<{}}  {:>7}  {:>7}  {:>9}  {:>8}  {:>8}  {:>6}  {:<16}\n", "robot", width, "frames",
                                 "tracked", "keyframes", "ms p50", "ms p99", "in map", "digest");
  for (const RobotReport& robot : report.robots)
    text += fmt::format("{:<{}}  {:>7}  {:>7}  {:>9}  {:>8.2f}  {:>8.2f}  {:>6}  {}\n", robot.name, width, robot.frames,
                        robot.tracked, robot.keyframes, robot.ms_per_frame.p50_ms, robot.ms_per_frame.p99_ms,
                        robot.in_global_map ? "yes" : "no", digest_text(robot.map_digest));
  for (const RobotReport& robot : report.robots) text += troubles(robot);
  return text;
}

namespace {

constexpr std::size_t kMostRefused = 10;

std::string refusals(const std::vector<Merge>& merges) {
  std::string text;
  std::size_t refused = 0;
  for (const Merge& merge : merges)
    if (!merge.refused.empty() && ++refused <= kMostRefused)
      text += fmt::format("{} and {} are not joined: {}\n", printable(merge.a), printable(merge.b),
                          printable(merge.refused));
  if (refused > kMostRefused) text += fmt::format("and {} more pairs, see the report\n", refused - kMostRefused);
  return text;
}

}  // namespace

std::string to_table(const std::vector<Merge>& merges) {
  if (merges.empty()) return {};
  std::size_t width = 5;
  for (const Merge& merge : merges) width = std::max({width, merge.a.size(), merge.b.size()});
  std::string text;
  for (const Merge& m : merges)
    if (m.refused.empty())
      text += fmt::format("{:<{}}  {:<{}}  {:>7}  {:>7}  {:>5}  {:>7}  {:>5.2f}  {:>8.1f}  {:>10.2f}  {:>8.1f}\n",
                          printable(m.a), width, printable(m.b), width, m.cloud_a, m.cloud_b, m.pairs, m.inliers,
                          m.ratio, m.error_mm, m.distance_m, m.turn_deg);
  if (!text.empty())
    text = fmt::format("{:<{}}  {:<{}}  {:>7}  {:>7}  {:>5}  {:>7}  {:>5}  {:>8}  {:>10}  {:>8}\n", "merge", width, "",
                       width, "cloud r", "cloud s", "pairs", "inliers", "ratio", "error mm", "distance m", "turn deg") +
           text;
  return text + refusals(merges);
}

}  // namespace onemap::daemon
