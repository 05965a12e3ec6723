// onemap-eval: estimated trajectories against ground truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "evaluation/evaluation.hpp"

namespace {

using namespace onemap;
using namespace onemap::evaluation;

constexpr int kBadInput = 2;

constexpr const char* kDescription =
    "Trajectory error against ground truth, for one robot or for a team.\n\n"
    "EST and GT are text files, one pose a line: timestamp tx ty tz qx qy qz qw (metres, unit quaternion, '#' starts\n"
    "a comment). Several pairs are one team: its estimates are in one frame and its truths in one frame, and a single\n"
    "rigid transform (no scale) aligns them together, so that a wrong merge counts in full. Printed in metres and\n"
    "degrees, for each robot and the team: matched poses, coverage (matched poses / lines of associations.txt beside\n"
    "GT; without that file, / estimates), ATE as RMSE, median and maximum, and the RPE as RMSE.";

Result<std::string> read(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return Error{path, "is a folder"};
  std::ifstream file(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file.is_open() || file.bad()) return Error{path, "cannot be read"};
  return text;
}

Result<std::vector<TimedPose>> read_trajectory(const std::string& path) {
  const Result<std::string> text = read(path);
  if (!text) return text.error();
  return parse_trajectory(*text, path);
}

Result<RobotTrajectories> read_robot(const std::string& estimate_path, const std::string& truth_path) {
  auto estimate = read_trajectory(estimate_path);
  if (!estimate) return estimate.error();
  auto truth = read_trajectory(truth_path);
  if (!truth) return truth.error();
  RobotTrajectories robot{estimate_path, truth_path, std::move(*estimate), std::move(*truth), std::nullopt};
  const std::filesystem::path list = std::filesystem::path(truth_path).parent_path() / "associations.txt";
  if (!std::filesystem::exists(list)) return robot;
  const Result<std::string> text = read(list.string());
  if (!text) return text.error();
  robot.sequence_frames = count_listed_frames(*text);
  if (*robot.sequence_frames == 0) return Error{list.string(), "no frames"};
  return robot;
}

Result<TeamEvaluation> run(const std::vector<std::string>& files, const EvaluationSettings& settings) {
  if (files.size() % 2 != 0) return Error{"", "files come in pairs: EST GT [EST GT ...]"};
  std::vector<RobotTrajectories> team;
  for (std::size_t i = 0; i < files.size(); i += 2) {
    Result<RobotTrajectories> robot = read_robot(files[i], files[i + 1]);
    if (!robot) return robot.error();
    team.push_back(std::move(*robot));
  }
  return evaluate(team, settings);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(kDescription, "onemap-eval");
  std::vector<std::string> files;
  EvaluationSettings settings;
  bool json = false;
  app.add_option("files", files, "EST GT [EST GT ...]")->required()->type_name("");
  app.add_option("--max-dt", settings.max_dt_s, "seconds between an estimate and its ground-truth pose")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--rpe", settings.rpe_delta_s, "seconds over which the relative pose error is taken")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--json", json, "print JSON");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadInput;
  }
  const Result<TeamEvaluation> evaluation = run(files, settings);
  if (!evaluation) {
    fmt::print(stderr, "onemap-eval: {}\n", evaluation.error().text());
    return kBadInput;
  }
  fmt::print("{}", json ? to_json(*evaluation) : to_text(*evaluation, settings));
  return 0;
} catch (const std::exception& error) {  // out of memory, or a closed standard output
  (void)std::fputs("onemap-eval: ", stderr);
  (void)std::fputs(error.what(), stderr);
  (void)std::fputs("\n", stderr);
  return kBadInput;
}
