// onemap-eval: estimated trajectories, and a map, against ground truth.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>

#include "daemon/command_line.hpp"
#include "evaluation/evaluation.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/base/file.hpp"
#include "render/gltf_writer.hpp"
#include "render/ply_reader.hpp"

namespace {

using namespace onemap;
using namespace onemap::daemon;
using namespace onemap::evaluation;

constexpr const char* kProgram = "onemap-eval";
constexpr const char* kDescription =
    "Trajectory error against ground truth, for one robot or for a team.\n\n"
    "EST and GT are text files, one pose a line: timestamp tx ty tz qx qy qz qw (metres, unit quaternion, '#' starts\n"
    "a comment). Several pairs are one team: its estimates are in one frame and its truths in one frame, and a single\n"
    "rigid transform (no scale) aligns them together, so that a wrong merge counts in full. Printed in metres and\n"
    "degrees, for each robot and the team: matched poses, coverage (matched poses / lines of associations.txt beside\n"
    "GT; without that file, / estimates), ATE as RMSE, median and maximum, and the RPE as RMSE.\n\n"
    "GT may also be a camera's address. Of a simulated one (simulated:SCENE?...) its truth is taken, of a recording\n"
    "or a part of one (replay:DIR:FROM:TO) DIR/groundtruth.txt, and coverage is of the frames of that part.\n\n"
    "A map in the frame of the estimates (--surface) is judged by the surfaces of the simulated room that GT names.\n"
    "On a terminal the answer is a table with units; otherwise a line a robot, for programs.";
constexpr const char* kFooter =
    "Examples:\n"
    "  onemap-eval out/trajectory.txt fr1_xyz/groundtruth.txt --table\n"
    "  onemap-eval out/robot1/global/robot1.txt replay:fr1_xyz:0:330 \\\n"
    "              out/robot1/global/robot2.txt replay:fr1_xyz:230:560\n"
    "  onemap-eval out/global/a.txt 'simulated:ring?frames=1200&fps=10' --json\n"
    "  onemap-eval out/trajectory.txt 'simulated:office?frames=300' --surface out/local.glb\n"
    "\nExit status: 0 done, 1 a file cannot be used, 2 wrong options.";

Result<std::vector<TimedPose>> read_trajectory(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_trajectory(*text, path);
}

// The truth of a simulated camera.
Result<std::vector<TimedPose>> truth_of(const hal::CameraAddress& address) {
  const auto truth = hal::simulated_truth(address);
  if (!truth) return truth.error();
  std::vector<TimedPose> out;
  for (const hal::SimulatedPose& pose : *truth) {
    const auto& [x, y, z, w] = pose.q_world_camera_xyzw;
    TimedPose& timed = out.emplace_back();
    timed.time_s = to_seconds(pose.time.time_since_epoch());
    timed.T_world_camera.linear() = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
    timed.T_world_camera.translation() = Eigen::Map<const Eigen::Vector3d>(pose.t_world_camera_m.data());
  }
  return out;
}

Result<RobotTrajectories> read_simulated(const std::string& estimate_path, const std::string& text) {
  const auto address = hal::parse_camera_address(text);
  if (!address) return address.error();
  auto truth = truth_of(*address);
  if (!truth) return truth.error();
  auto estimate = read_trajectory(estimate_path);
  if (!estimate) return estimate.error();
  const std::size_t frames = truth->size();
  return RobotTrajectories{estimate_path, text, std::move(*estimate), std::move(*truth), frames};
}

// Of `DIR` or `DIR:FROM:TO`.
struct Part {
  std::string folder;
  std::optional<std::pair<std::size_t, std::size_t>> range;
};
Part part_of(const std::string& path) {
  const auto number_behind = [&](std::size_t colon, std::size_t end) -> std::optional<std::size_t> {
    std::size_t value = 0;
    const char *const from = path.data() + colon + 1, *const to = path.data() + end;
    const auto [stop, code] = std::from_chars(from, to, value);
    return code == std::errc{} && stop == to ? std::optional(value) : std::nullopt;
  };
  const std::size_t second = path.rfind(':');
  const std::size_t first = second == std::string::npos || second == 0 ? second : path.rfind(':', second - 1);
  if (first == std::string::npos || first == second) return {path, std::nullopt};
  const auto from = number_behind(first, second), to = number_behind(second, path.size());
  if (!from || !to) return {path, std::nullopt};
  return {path.substr(0, first), std::pair(*from, *to)};
}

// The frames of associations.txt beside the truth; without that file, none.
Result<std::optional<std::size_t>> listed_frames(const std::filesystem::path& folder) {
  const std::filesystem::path list = folder / "associations.txt";
  if (!std::filesystem::exists(list)) return std::optional<std::size_t>();
  const Result<std::string> text = read_text_file(list.string());
  if (!text) return text.error();
  const std::size_t frames = count_listed_frames(*text);
  if (frames == 0) return Error{list.string(), "no frames"};
  return std::optional(frames);
}

Result<RobotTrajectories> read_recorded(const std::string& estimate_path, const std::string& truth_path,
                                        const std::filesystem::path& folder) {
  auto estimate = read_trajectory(estimate_path);
  if (!estimate) return estimate.error();
  auto truth = read_trajectory(truth_path);
  if (!truth) return truth.error();
  const auto frames = listed_frames(folder);
  if (!frames) return frames.error();
  return RobotTrajectories{estimate_path, truth_path, std::move(*estimate), std::move(*truth), *frames};
}

Result<RobotTrajectories> read_part(const std::string& estimate_path, const std::string& text) {
  const auto address = hal::parse_camera_address(text);
  if (!address) return address.error();
  const auto [folder, range] = part_of(address->path);
  auto robot = read_recorded(estimate_path, folder + "/groundtruth.txt", folder);
  if (!robot || !range) return robot;
  const std::size_t end = std::min(range->second, robot->sequence_frames.value_or(range->second));
  if (range->first >= end) return Error{text, "no frames"};
  robot->sequence_frames = end - range->first;
  return robot;
}

Result<RobotTrajectories> read_robot(const std::string& estimate_path, const std::string& truth_path) {
  if (truth_path.starts_with("simulated:")) return read_simulated(estimate_path, truth_path);
  if (truth_path.starts_with("replay:")) return read_part(estimate_path, truth_path);
  return read_recorded(estimate_path, truth_path, std::filesystem::path(truth_path).parent_path());
}

Result<TeamEvaluation> run(const std::vector<std::string>& files, const EvaluationSettings& settings) {
  std::vector<RobotTrajectories> team;
  for (std::size_t i = 0; i < files.size(); i += 2) {
    Result<RobotTrajectories> robot = read_robot(files[i], files[i + 1]);
    if (!robot) return robot.error();
    team.push_back(std::move(*robot));
  }
  return evaluate(team, settings);
}

Result<std::vector<mapping::Vector3f>> read_points(const std::string& map) {
  if (map.ends_with(".glb")) {
    auto scene = render::read_glb(map);
    if (!scene) return scene.error();
    return std::move(scene->mesh.vertices.empty() ? scene->points.points : scene->mesh.vertices);
  }
  if (!map.ends_with(".ply")) return Error{map, "neither a .ply nor a .glb"};
  auto mesh = render::read_ply(map);
  if (!mesh) return mesh.error();
  return std::move(mesh->vertices);
}

Status add_surface(const std::string& map, const std::string& truth, TeamEvaluation& evaluation) {
  const auto address = hal::parse_camera_address(truth);
  if (!address || address->backend != "simulated")
    return Error{"--surface", "the true surface is known of simulated rooms only, and GT is " + truth};
  const auto distance_m = hal::simulated_surface(*address);
  if (!distance_m) return distance_m.error();
  const auto points = read_points(map);
  if (!points) return points.error();
  if (points->empty()) return Error{map, "has no points"};
  evaluation.surface = evaluate_surface(*points, evaluation.T_truth_estimate, *distance_m);
  evaluation.surface->name = map;
  return success();
}

// CLI::NonNegativeNumber and CLI::PositiveNumber let through what is not a number.
std::string wrong(const std::vector<std::string>& files, const EvaluationSettings& settings) {
  if (files.size() % 2 != 0) return "files come in pairs: EST GT [EST GT ...]";
  if (!(settings.max_dt_s >= 0 && settings.max_dt_s <= 1e9)) return "--max-dt: not a number from 0 to 1e9";
  if (!(settings.rpe_delta_s > 0 && settings.rpe_delta_s <= 1e9)) return "--rpe: not a number above 0, up to 1e9";
  return {};
}

Ending eval(const std::vector<std::string>& arguments) {
  CLI::App app(kDescription, kProgram);
  std::vector<std::string> files;
  EvaluationSettings settings;
  bool json = false, table = false;
  std::string surface;
  app.add_option("files", files, "EST GT [EST GT ...]")->required()->type_name("");
  app.add_option("--max-dt", settings.max_dt_s, "seconds between an estimate and its ground-truth pose")
      ->capture_default_str();
  app.add_option("--rpe", settings.rpe_delta_s, "seconds over which the relative pose error is taken")
      ->capture_default_str();
  app.add_option("--surface", surface, "also judge this map, a .ply or .glb, by the simulated room of the first GT")
      ->type_name("MAP");
  auto* as_json = app.add_flag("--json", json, "print JSON");
  app.add_flag("--table", table, "print a table with units")->excludes(as_json);
  app.footer(kFooter);
  if (auto ending = parse_command_line(app, arguments)) return *ending;
  if (const std::string what = wrong(files, settings); !what.empty()) return {Exit::usage, complaint(kProgram, what)};
  Result<TeamEvaluation> evaluation = run(files, settings);
  if (!evaluation) return {Exit::failed, complaint(kProgram, evaluation.error().text())};
  if (!surface.empty())
    if (const auto judged = add_surface(surface, files[1], *evaluation); !judged)
      return {Exit::failed, complaint(kProgram, judged.error().text())};
  if (json) return {Exit::done, to_json(*evaluation)};
  return {Exit::done,
          table || isatty(STDOUT_FILENO) == 1 ? to_table(*evaluation, settings) : to_text(*evaluation, settings)};
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(kProgram, argc, argv, [](const auto& arguments) { return end(eval(arguments)); });
}
