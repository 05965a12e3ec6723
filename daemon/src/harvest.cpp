#include "daemon/harvest.hpp"

#include <algorithm>

#include "daemon/clock.hpp"
#include "daemon/merges.hpp"
#include "daemon/standing.hpp"
#include "daemon/team_picture.hpp"
#include "daemon/team_words.hpp"
#include "hal/base/file.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/way_on_map.hpp"
#include "render/map_server_writer.hpp"
#include "render/png_writer.hpp"

namespace onemap::daemon {

void Harvest::keep(const Status& status) {
  if (status) return;
  log_.error("not written: {}; make room, or let it write there, before it is started again", status.error().text());
  if (first_) first_ = status;
}

Status Harvest::write(Extent extent) {
  say_costs();
  if (!config_.alone())
    keep(guarded("merges", [this] {
      merges_ = merges_of(from_.team.map());
      return success();
    }));
  keep(guarded("trajectories", [this] { return write_trajectories(); }));
  keep(guarded("pose graph", [this] { return write_graph(); }));
  if (extent == Extent::everything) write_what_takes_long();
  // The report comes last: who finds it finds everything else.
  keep(guarded("report", [this] { return write_text_file(config_.out + "/report.json", to_json(report())); }));
  return first_;
}

void Harvest::write_what_takes_long() {
  if (!config_.alone())
    keep(guarded("team picture", [this] {
      return render::write_png(config_.out + "/team.png", draw_team(team_picture(from_.team.map(), merges_)));
    }));
  keep(guarded("floor plan", [this] { return write_plan(); }));
  keep(guarded("pictures", [this] { return draw(); }));
}

std::optional<std::vector<std::uint8_t>> Harvest::saved_map() const {
  const MapSource from = source();
  if (from.solution == nullptr || from.map == nullptr) return std::nullopt;
  return save_global(from, "the last map of " + config_.id);
}

Status Harvest::draw() {
  for (const PictureResult& result : write_pictures(pictures())) {
    keep(result.status);
    if (result.status) vertices_ = result.vertices;
  }
  return success();
}

void Harvest::say_costs() const {
  const LatencyHistogram& times = from_.pipeline.frame_times();
  log_.line("{} frames, {:.2f} ms of processor time each (p50 {:.2f}, p99 {:.2f}); by step: {}", times.count(),
            times.total_ms() / std::max<double>(1, static_cast<double>(times.count())), times.quantile_ms(0.5),
            times.quantile_ms(0.99), from_.pipeline.step_table());
  const mapping::SurfaceCounters surface = from_.pipeline.mapper().counters().surface;
  log_.line("{} submaps begun, {} opened again, {} left the shelf", surface.submaps, surface.reopened,
            surface.submaps_dropped);
  if (surface.frames_waiting > 0)
    log_.line("{} frames are in no submap: those that were left had not been handed out yet", surface.frames_waiting);
  const CaptureCounters captured = from_.capture.counters();
  if (captured.dropped + captured.bad > 0)
    log_.line("{} frames dropped to keep pace, {} could not be read", captured.dropped, captured.bad);
  if (captured.missed + captured.unmatched > 0)
    log_.line("{} frames of the camera were not fetched in time, {} images had no partner", captured.missed,
              captured.unmatched);
  if (captured.gone > 0) log_.line("the camera went away {} times", captured.gone);
  if (captured.frozen + captured.black + captured.saturated + captured.no_depth + captured.time_back > 0)
    log_.line("frames with faults: {} like the one before, {} black, {} white, {} without depth, {} back in time",
              captured.frozen, captured.black, captured.saturated, captured.no_depth, captured.time_back);
}

Status Harvest::write_trajectories() const {
  if (auto status = write_text_file(config_.out + "/trajectory.txt", trajectory_text(from_.pipeline.poses())); !status)
    return status;
  const mapping::SolutionRecord* solution = from_.team.map().solution();
  if (solution == nullptr) return success();
  if (auto status = make_folder(config_.out + "/global"); !status) return status;
  const mapping::TeamLog& log = from_.team.map().log();
  for (const mapping::SolvedRobot& solved : solution->robots) {
    const mapping::TeamMember* member = log.find(solved.chain);
    if (member == nullptr || !solved.chain.robot.valid()) continue;  // a file's name is a checked name
    const std::string file = config_.out + "/global/" + chain_name(log, solved.chain) + ".txt";
    const std::string text = trajectory_text(mapping::way_on_map(*member, solved));
    if (auto status = write_text_file(file, text); !status) return status;
  }
  return success();
}

Status Harvest::write_graph() const {
  const std::string text = from_.team.map().graph();
  return text.empty() ? success() : write_text_file(config_.out + "/graph.g2o", text);
}

Status Harvest::write_plan() {
  const Instant began = now();
  auto survey = survey_of(source(), config_.plan);
  if (!survey) {  // a desk without a floor is no failure
    log_.line("no {}", survey.error().text());
    return success();
  }
  survey_ = std::move(*survey);
  auto written = render::write_map_server(config_.out + "/map", survey_->plan, survey_->T_level_map);
  say_plan(now() - began);
  return written;
}

void Harvest::say_plan(Duration took) const {
  const mapping::Survey& s = *survey_;
  log_.line("floor plan of {} x {} squares from {} keyframes in {:.0f} ms, {} blocks of free space", s.plan.width,
            s.plan.height, s.space.keyframes, to_seconds(took) * 1e3, s.blocks);
  if (s.space.votes_refused > 0)
    log_.warn("the floor plan's free space is full: {} votes refused; raise map.plan_budget_mb or map.plan_cell_m",
              s.space.votes_refused);
  const std::uint64_t unusable = s.keyframes_malformed + s.space.keyframes_refused;
  if (s.keyframes_left_out + unusable > 0)
    log_.line("the floor plan is without {} keyframes that were too many, and {} that could not be used",
              s.keyframes_left_out, unusable);
}

MapSource Harvest::source() const {
  const mapping::TeamMap& team = from_.team.map();
  return {team.log(), team.solution(), team.map()};
}

std::vector<MapPicture> Harvest::pictures() const {
  const std::string local_title = "local map of " + config_.id;
  const MapSource from = source();
  // A robot alone has one map, with its loops closed.
  if (from.solution != nullptr && config_.alone()) return {{config_.out + "/local", save_global(from, local_title)}};
  std::vector<MapPicture> pictures;
  if (auto local = save_local(from, config_, local_title))
    pictures.push_back({config_.out + "/local", std::move(*local)});
  if (from.solution != nullptr) pictures.push_back({config_.out + "/global", save_global(from, "global map")});
  return pictures;
}

RobotReport Harvest::robot_report() const {
  RobotReport robot;
  robot.name = config_.id;
  robot.camera = config_.camera;
  robot.frames = from_.capture.counters().grabbed;
  robot.tracked = from_.pipeline.progress().tracked;
  robot.keyframes = from_.pipeline.keyframes_published();
  robot.ms_per_frame = from_.pipeline.frame_times().quantiles();
  robot.peak_rss_mb = from_.peak_rss_mb;
  if (survey_) {
    robot.plan_squares = survey_->plan.cells.size();
    robot.plan_votes_refused = survey_->space.votes_refused;
  }
  robot.blocks_refused = from_.pipeline.mapper().counters().surface.blocks_refused;
  return robot;
}

Report Harvest::report() const {
  Report report;
  RobotReport robot = robot_report();
  const TeamView team = from_.team.view();
  const RadioView radio = from_.radio.view();
  report.same_map = from_.agreed;
  report.merge_ms = static_cast<std::uint64_t>(to_seconds(team.merge) * 1e3);
  if (const mapping::SolutionRecord* solution = from_.team.map().solution(); solution != nullptr) {
    report.reference = solution->reference.robot.name();
    robot.in_global_map = mapping::find_solved(*solution, from_.team.map().log().own_chain()) != nullptr;
  }
  robot.map_digest = team.digest;
  robot.bytes_sent = radio.bytes_sent;
  robot.bytes_received = radio.bytes_received;
  robot.refused = refusals(team, radio);
  report.global_points = vertices_;
  report.robots.push_back(std::move(robot));
  report.merges = merges_;
  return report;
}

}  // namespace onemap::daemon
