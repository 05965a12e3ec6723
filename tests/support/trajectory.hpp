#pragma once
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/text_of.hpp"

namespace onemap::test {

// Positions of a TUM file by time in microseconds.
inline std::map<long long, Eigen::Vector3d> read_positions(const std::filesystem::path& file) {
  std::map<long long, Eigen::Vector3d> positions;
  for (const std::string& line : lines_of(file)) {
    double time = 0;
    Eigen::Vector3d t;
    if (std::istringstream(line) >> time >> t.x() >> t.y() >> t.z()) positions[std::llround(time * 1e6)] = t;
  }
  return positions;
}

// Root mean square distance of estimates (first) to truths after one rigid alignment of them all (Umeyama without
// scale). Not a number when there are fewer than three.
inline double aligned_rms(const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>& matched) {
  if (matched.size() < 3) return std::nan("");
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  for (const auto& [e, t] : matched) {
    a += e;
    b += t;
  }
  a /= static_cast<double>(matched.size());
  b /= static_cast<double>(matched.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& [e, t] : matched) covariance += (t - b) * (e - a).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(2, 2) = -1;
  const Eigen::Matrix3d R = svd.matrixU() * sign * svd.matrixV().transpose();
  double sum = 0;
  for (const auto& [e, t] : matched) sum += (R * (e - a) + b - t).squaredNorm();
  return std::sqrt(sum / static_cast<double>(matched.size()));
}

// That of all pairs of files together: a robot that is well tracked but wrongly merged counts in full.
inline double team_ate(const std::vector<std::pair<std::filesystem::path, std::filesystem::path>>& pairs) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> matched;
  for (const auto& [estimate, truth] : pairs) {
    const auto truths = read_positions(truth);
    for (const auto& [time, position] : read_positions(estimate))
      if (const auto t = truths.find(time); t != truths.end()) matched.emplace_back(position, t->second);
  }
  return aligned_rms(matched);
}

}  // namespace onemap::test
