#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"

// Trajectory and surface error against ground truth, for one robot or a team. Pure functions: text in, numbers out.
namespace onemap::evaluation {

struct TimedPose {
  double time_s = 0;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();  // metres
};

// TUM format: `timestamp tx ty tz qx qy qz qw` a line, separated by blanks or commas, '#' starts a comment; quaternions
// are normalised. Sorted by time. Errors carry NAME:LINE; a file without poses is an error.
Result<std::vector<TimedPose>> parse_trajectory(std::string_view text, const std::string& name);

// Lines of an associations.txt that are neither blank nor comments: the frames that the sequence has.
std::size_t count_listed_frames(std::string_view text);

// One robot. All estimates of a team are in one frame, and all ground truths are in one frame.
struct RobotTrajectories {
  std::string estimate_name, truth_name;
  std::vector<TimedPose> estimate, truth;      // sorted by time, not empty
  std::optional<std::size_t> sequence_frames;  // without it, coverage is by the estimates
};

struct EvaluationSettings {
  double max_dt_s = 0.02;    // between an estimate and the ground-truth pose that it takes
  double rpe_delta_s = 1.0;  // between the two poses of a relative error; pairs a quarter off are left out
};

struct RelativeError {
  double translation_m = 0, rotation_deg = 0;  // root mean squares
};

// Absolute errors are in metres, of the matched positions after a rigid alignment (no scale).
struct RobotEvaluation {
  std::string estimate_name;
  std::size_t poses = 0;                      // matched
  double coverage = 0;                        // poses / frames of the sequence
  std::optional<RelativeError> rpe;           // none when no two poses are rpe_delta_s apart
  double ate_alone = 0;                       // RMSE, aligned by itself
  double ate_joint = 0, median = 0, max = 0;  // aligned with the whole team
};

// A map's points against the true surface: metres.
struct SurfaceEvaluation {
  std::string name;
  std::size_t points = 0;
  double rms = 0, median = 0, p95 = 0;
  double off = 0;  // share beyond kOff_m
};
constexpr double kOff_m = 0.03;

struct TeamEvaluation {
  std::vector<RobotEvaluation> robots;
  std::size_t poses = 0;
  double coverage = 0;                  // the least of any robot
  double ate = 0, median = 0, max = 0;  // one alignment for all robots
  // By places and gazes: those of a short way would leave a map's far end centimetres off.
  Eigen::Isometry3d T_truth_estimate = Eigen::Isometry3d::Identity();
  std::optional<SurfaceEvaluation> surface;  // where there was a map
};

// At least one robot. The error names an estimate of which fewer than three poses match.
Result<TeamEvaluation> evaluate(const std::vector<RobotTrajectories>& team, const EvaluationSettings& settings);

// The points of a map, metres in the frame of the estimates, by how far each is from the true surface. At least one.
SurfaceEvaluation evaluate_surface(std::span<const Eigen::Vector3f> points, const Eigen::Isometry3d& T_truth_estimate,
                                   const std::function<double(const std::array<double, 3>&)>& distance_m);

// The rigid T_b_a that takes the columns of a closest to those of b in least squares (Umeyama 1991, without scale).
Eigen::Isometry3d align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b);

std::string to_json(const TeamEvaluation& evaluation);
// A line a robot and one for the team, for programs that read such lines.
std::string to_text(const TeamEvaluation& evaluation, const EvaluationSettings& settings);
// The same for people: columns with their units.
std::string to_table(const TeamEvaluation& evaluation, const EvaluationSettings& settings);

}  // namespace onemap::evaluation
