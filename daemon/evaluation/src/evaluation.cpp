#include "evaluation/evaluation.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace onemap::evaluation {

namespace {

struct Match {
  std::size_t estimate, truth;
};

// The matched positions of one robot, a column each.
struct MatchedPositions {
  Eigen::Matrix3Xd estimate, truth;
};

// Index of the first pose that is not before the time.
std::size_t first_at(const std::vector<TimedPose>& poses, double time_s) {
  const auto found = std::lower_bound(poses.begin(), poses.end(), time_s,
                                      [](const TimedPose& pose, double t) { return pose.time_s < t; });
  return static_cast<std::size_t>(found - poses.begin());
}

// Each estimate takes the ground-truth pose nearest in time, the earlier of two that are equally near.
std::vector<Match> match(const RobotTrajectories& robot, double max_dt_s) {
  std::vector<Match> matches;
  const std::vector<TimedPose>& truth = robot.truth;
  for (std::size_t i = 0; i < robot.estimate.size(); ++i) {
    const double t = robot.estimate[i].time_s;
    std::size_t best = first_at(truth, t);
    const bool earlier =
        best == truth.size() || (best > 0 && std::abs(truth[best - 1].time_s - t) <= std::abs(truth[best].time_s - t));
    if (earlier) --best;
    if (std::abs(truth[best].time_s - t) <= max_dt_s) matches.push_back({i, best});
  }
  return matches;
}

MatchedPositions positions(const RobotTrajectories& robot, const std::vector<Match>& matches) {
  MatchedPositions p;
  p.estimate.resize(3, static_cast<Eigen::Index>(matches.size()));
  p.truth.resize(3, static_cast<Eigen::Index>(matches.size()));
  for (Eigen::Index k = 0; k < p.estimate.cols(); ++k) {
    const Match& m = matches[static_cast<std::size_t>(k)];
    p.estimate.col(k) = robot.estimate[m.estimate].T_world_camera.translation();
    p.truth.col(k) = robot.truth[m.truth].T_world_camera.translation();
  }
  return p;
}

MatchedPositions joined(const std::vector<MatchedPositions>& parts) {
  Eigen::Index columns = 0, at = 0;
  for (const MatchedPositions& part : parts) columns += part.estimate.cols();
  MatchedPositions all{Eigen::Matrix3Xd(3, columns), Eigen::Matrix3Xd(3, columns)};
  for (const MatchedPositions& part : parts) {
    all.estimate.middleCols(at, part.estimate.cols()) = part.estimate;
    all.truth.middleCols(at, part.truth.cols()) = part.truth;
    at += part.estimate.cols();
  }
  return all;
}

Eigen::VectorXd distances(const Eigen::Isometry3d& T_truth_estimate, const MatchedPositions& p) {
  const Eigen::Matrix3Xd aligned = (T_truth_estimate.linear() * p.estimate).colwise() + T_truth_estimate.translation();
  return (aligned - p.truth).colwise().norm();
}

double root_mean_square(const Eigen::VectorXd& v) { return std::sqrt(v.squaredNorm() / static_cast<double>(v.size())); }

double median(const Eigen::VectorXd& v) {
  std::vector<double> sorted(v.data(), v.data() + v.size());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  return (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
}

// As the public align(), with a sum of rotations R_b_a that count as well: a metre of places as much as a radian.
Eigen::Isometry3d align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, const Eigen::Matrix3d& rotations) {
  const Eigen::Vector3d mean_a = a.rowwise().mean(), mean_b = b.rowwise().mean();
  const Eigen::Matrix3d covariance = (b.colwise() - mean_b) * (a.colwise() - mean_a).transpose() + rotations;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Eq. 39 and 43: a reflection is undone along the weakest direction.
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();
  T_b_a.linear() = svd.matrixU() * Eigen::Vector3d(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
  T_b_a.translation() = mean_b - T_b_a.linear() * mean_a;
  return T_b_a;
}

Eigen::Matrix3d rotations_of(const RobotTrajectories& robot, const std::vector<Match>& matches) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Match& m : matches)
    sum +=
        robot.truth[m.truth].T_world_camera.linear() * robot.estimate[m.estimate].T_world_camera.linear().transpose();
  return sum;
}

// Root mean squares of the error of the motion from each match to the first that is delta later by the truth's clock.
std::optional<RelativeError> relative_error(const RobotTrajectories& robot, const std::vector<Match>& matches,
                                            double delta_s) {
  double translation = 0, rotation = 0;
  std::size_t count = 0;
  const auto time = [&](const Match& m) { return robot.truth[m.truth].time_s; };
  for (const Match& from : matches) {
    const double wanted = time(from) + delta_s;
    const auto to =
        std::lower_bound(matches.begin(), matches.end(), wanted, [&](const Match& m, double t) { return time(m) < t; });
    if (to == matches.end() || std::abs(time(*to) - time(from) - delta_s) > delta_s * 0.25) continue;
    const Eigen::Isometry3d estimate =
        robot.estimate[from.estimate].T_world_camera.inverse() * robot.estimate[to->estimate].T_world_camera;
    const Eigen::Isometry3d truth =
        robot.truth[from.truth].T_world_camera.inverse() * robot.truth[to->truth].T_world_camera;
    const Eigen::Isometry3d error = truth.inverse() * estimate;
    const double cosine = std::clamp((error.linear().trace() - 1) / 2, -1.0, 1.0);
    const double degrees = std::acos(cosine) * 180 / std::numbers::pi;
    translation += error.translation().squaredNorm();
    rotation += degrees * degrees;
    ++count;
  }
  if (count == 0) return std::nullopt;
  const auto n = static_cast<double>(count);
  return RelativeError{std::sqrt(translation / n), std::sqrt(rotation / n)};
}

}  // namespace

Eigen::Isometry3d align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return align(a, b, Eigen::Matrix3d::Zero());
}

Result<TeamEvaluation> evaluate(const std::vector<RobotTrajectories>& team, const EvaluationSettings& settings) {
  assert(!team.empty());
  TeamEvaluation result;
  std::vector<MatchedPositions> parts;
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (const RobotTrajectories& robot : team) {
    const std::vector<Match> matches = match(robot, settings.max_dt_s);
    if (matches.size() < 3)
      return Error{robot.estimate_name, fmt::format("only {} poses match {} within {} s", matches.size(),
                                                    robot.truth_name, settings.max_dt_s)};
    RobotEvaluation one;
    one.estimate_name = robot.estimate_name;
    one.poses = matches.size();
    one.coverage = static_cast<double>(matches.size()) /
                   static_cast<double>(robot.sequence_frames.value_or(robot.estimate.size()));
    one.rpe = relative_error(robot, matches, settings.rpe_delta_s);
    result.robots.push_back(std::move(one));
    parts.push_back(positions(robot, matches));
    rotations += rotations_of(robot, matches);
  }
  const MatchedPositions all = joined(parts);
  const Eigen::Isometry3d T_truth_team = align(all.estimate, all.truth);
  result.T_truth_estimate = align(all.estimate, all.truth, rotations);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    RobotEvaluation& one = result.robots[i];
    const Eigen::VectorXd joint = distances(T_truth_team, parts[i]);
    one.ate_alone = root_mean_square(distances(align(parts[i].estimate, parts[i].truth), parts[i]));
    one.ate_joint = root_mean_square(joint);
    one.median = median(joint);
    one.max = joint.maxCoeff();
    result.coverage = i == 0 ? one.coverage : std::min(result.coverage, one.coverage);
  }
  const Eigen::VectorXd joint = distances(T_truth_team, all);
  result.poses = static_cast<std::size_t>(joint.size());
  result.ate = root_mean_square(joint);
  result.median = median(joint);
  result.max = joint.maxCoeff();
  return result;
}

}  // namespace onemap::evaluation
