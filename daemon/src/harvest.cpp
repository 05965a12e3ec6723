#include "daemon/harvest.hpp"

#include <algorithm>

#include "daemon/clock.hpp"
#include "daemon/saved_map.hpp"
#include "daemon/standing.hpp"
#include "daemon/team_picture.hpp"
#include "hal/base/file.hpp"
#include "mapping/team/local_atlas.hpp"
#include "render/map_server_writer.hpp"
#include "render/png_writer.hpp"

namespace onemap::daemon {

namespace {
SavedPath make_path(const std::string& name, render::Color color, const std::vector<mapping::StampedPose>& poses,
                    const std::vector<mapping::QuantizedPose>& keyframes,
                    const mapping::QuantizedPose& T_map_robot = {}) {
  SavedPath path{name, color, T_map_robot, {}, keyframes};
  path.poses.reserve(poses.size());
  for (const mapping::StampedPose& pose : poses) path.poses.push_back(pose.T_robot_camera);
  return path;
}

std::vector<mapping::QuantizedPose> keyframe_poses(const mapping::TeamMember& member) {
  std::vector<mapping::QuantizedPose> out;
  for (const mapping::KeyframePlace& place : member.places) out.push_back(place.T_robot_keyframe);
  return out;
}
void add_placed(const mapping::TeamMember& member, const mapping::Pose& T_map_robot,
                std::vector<mapping::PlacedKeyframe>& out) {
  for (std::size_t i = 0; i < member.keyframes.size(); ++i)
    out.push_back(
        {member.keyframes[i]->body, T_map_robot * mapping::from_quantized(member.places[i].T_robot_keyframe)});
}
}  // namespace

void Harvest::keep(const Status& status) {
  if (status) return;
  log_.line("not written: {}", status.error().text());
  if (first_) first_ = status;
}

Status Harvest::write() {
  say_costs();
  keep(guarded("trajectories", [this] { return write_trajectories(); }));
  if (from_.team)
    keep(guarded("team picture", [this] {
      return render::write_png(config_.out + "/team.png", draw_team(team_picture(from_.team->map())));
    }));
  keep(guarded("floor plan", [this] { return write_plan(); }));
  keep(guarded("pictures", [this] { return draw(); }));
  // The report comes last: who finds it finds everything else.
  keep(guarded("report", [this] { return write_text_file(config_.out + "/report.json", to_json(report())); }));
  return first_;
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
  const CaptureCounters captured = from_.capture.counters();
  if (captured.dropped + captured.bad > 0)
    log_.line("{} frames dropped to keep pace, {} could not be read", captured.dropped, captured.bad);
  if (captured.gone > 0) log_.line("the camera went away {} times", captured.gone);
}

Status Harvest::write_trajectories() const {
  if (auto status = write_text_file(config_.out + "/trajectory.txt", trajectory_text(from_.pipeline.poses())); !status)
    return status;
  const auto solution = from_.team ? from_.team->map().solution() : std::nullopt;
  if (!solution) return success();
  if (auto status = make_folder(config_.out + "/global"); !status) return status;
  const auto& members = from_.team->map().members();
  for (const auto& solved : solution->robots) {
    const auto member = members.find(solved.robot);
    if (member == members.end() || !solved.robot.valid()) continue;  // a file's name is a checked name
    const std::string file = config_.out + "/global/" + solved.robot.name() + ".txt";
    const std::string text =
        trajectory_text(member->second.trajectory(), mapping::from_quantized(solved.T_global_robot));
    if (auto status = write_text_file(file, text); !status) return status;
  }
  return success();
}

// Of the global map, and without one of this robot's own.
std::vector<mapping::PlacedKeyframe> Harvest::placed_keyframes() const {
  std::vector<mapping::PlacedKeyframe> placed;
  if (!from_.team) {
    for (const auto& kept : from_.pipeline.kept_keyframes().all())
      placed.push_back({kept.body, mapping::from_quantized(kept.T_robot_keyframe)});
    return placed;
  }
  const auto& members = from_.team->map().members();
  if (const auto solution = from_.team->map().solution()) {
    for (const auto& solved : solution->robots)
      if (const auto member = members.find(solved.robot); member != members.end())
        add_placed(member->second, mapping::from_quantized(solved.T_global_robot), placed);
  } else if (const auto own = members.find(RobotId::from_name(config_.id)); own != members.end()) {
    add_placed(own->second, {}, placed);
  }
  return placed;
}

Status Harvest::write_plan() {
  const Instant began = now();
  auto survey = mapping::survey(placed_keyframes(), config_.plan);
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
    log_.line("the floor plan's free space is full: {} votes refused; raise map.plan_budget_mb or map.plan_cell_m",
              s.space.votes_refused);
  const std::uint64_t left_out = s.keyframes_left_out + from_.pipeline.kept_keyframes().left_out();
  const std::uint64_t unusable = s.keyframes_malformed + s.space.keyframes_refused;
  if (left_out + unusable > 0)
    log_.line("the floor plan is without {} keyframes that were too many, and {} that could not be used", left_out,
              unusable);
}

// The same in every picture of the team, whoever draws it.
render::Color Harvest::color_of(const std::string& robot) const {
  std::vector<std::string> names;
  if (from_.team)
    for (const auto& [id, member] : from_.team->map().members()) names.push_back(id.name());
  if (std::ranges::find(names, robot) == names.end()) names.push_back(robot);
  const auto place = std::ranges::find(names, robot) - names.begin();
  return render::robot_colors(names)[static_cast<std::size_t>(place)];
}

MapPicture Harvest::global_picture(const mapping::SolutionRecord& solution) const {
  const auto& members = from_.team->map().members();
  std::vector<SavedPath> paths;
  for (const auto& solved : solution.robots)
    if (const auto member = members.find(solved.robot); member != members.end())
      paths.push_back(make_path(solved.robot.name(), color_of(solved.robot.name()), member->second.trajectory(),
                                keyframe_poses(member->second), solved.T_global_robot));
  return {config_.out + "/global", save_map("global map", paths, *from_.team->map().map())};
}

const mapping::VoxelMap& Harvest::local_map() const {
  if (!local_) {
    mapping::AtlasConfig config{config_.mapper.map};
    config.map.budget_bytes = config_.global_budget_bytes;
    local_ = mapping::local_atlas(from_.pipeline.mapper(), config);
  }
  return local_->map();
}

std::vector<MapPicture> Harvest::pictures() const {
  const SavedPath path =
      make_path(config_.id, color_of(config_.id), from_.pipeline.poses(), from_.pipeline.keyframe_poses());
  std::vector<MapPicture> pictures;
  pictures.push_back({config_.out + "/local", save_map("local map of " + config_.id, {&path, 1}, local_map())});
  const auto solution = from_.team ? from_.team->map().solution() : std::nullopt;
  if (solution && from_.team->map().map()) pictures.push_back(global_picture(*solution));
  return pictures;
}

RobotReport Harvest::robot_report() const {
  RobotReport robot;
  robot.name = config_.id;
  robot.camera = config_.camera;
  robot.frames = from_.capture.counters().grabbed;
  robot.tracked = from_.pipeline.poses().size();
  robot.keyframes = from_.pipeline.keyframe_poses().size();
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
  if (from_.team) {
    const TeamView team = from_.team->view();
    report.same_map = from_.agreed;
    report.merge_ms = static_cast<std::uint64_t>(to_seconds(team.merge) * 1e3);
    if (const auto solution = from_.team->map().solution()) {
      report.reference = solution->reference.name();
      for (const auto& solved : solution->robots) robot.in_global_map |= solved.robot == RobotId::from_name(config_.id);
    }
    robot.map_digest = team.digest;
    const RadioView radio = from_.radio->view();
    robot.bytes_sent = radio.bytes_sent;
    robot.bytes_received = radio.bytes_received;
    robot.refused = refusals(team, radio);
  } else {
    report.same_map = true;
    report.reference = config_.id;
    robot.in_global_map = true;
    robot.map_digest = local_map().digest();
  }
  report.global_points = vertices_;
  report.robots.push_back(std::move(robot));
  return report;
}

}  // namespace onemap::daemon
