#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "evaluation/evaluation.hpp"

namespace onemap::evaluation {

namespace {

constexpr std::size_t kColumns = 8;
constexpr std::string_view kBlank = " \t\r\f\v,";

// Calls each(line number, rest of the line without comment) for every line that is not blank.
template <class Each>
void for_each_line(std::string_view text, Each each) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r\f\v") != std::string_view::npos) each(number, line);
  }
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlank); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

bool parse_number(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return code == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

Result<TimedPose> parse_pose(std::string_view line) {
  const std::vector<std::string_view> words = split(line);
  if (words.size() != kColumns)
    return Error{"", fmt::format("{} values where {} are expected", words.size(), kColumns)};
  std::array<double, kColumns> v{};
  for (std::size_t i = 0; i < kColumns; ++i)
    if (!parse_number(words[i], v[i])) return Error{"", fmt::format("'{}' is not a finite number", words[i])};
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (!(q.norm() > 1e-9)) return Error{"", "the quaternion is zero"};
  TimedPose pose;
  pose.time_s = v[0];
  pose.T_world_camera.linear() = q.normalized().toRotationMatrix();
  pose.T_world_camera.translation() = Eigen::Vector3d(v[1], v[2], v[3]);
  return pose;
}

}  // namespace

Result<std::vector<TimedPose>> parse_trajectory(std::string_view text, const std::string& name) {
  std::vector<TimedPose> poses;
  std::optional<Error> error;
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    if (error) return;
    const Result<TimedPose> pose = parse_pose(line);
    if (pose) poses.push_back(*pose);
    if (!pose) error = Error{fmt::format("{}:{}", name, number), pose.error().reason};
  });
  if (error) return *error;
  if (poses.empty()) return Error{name, "no poses"};
  std::stable_sort(poses.begin(), poses.end(),
                   [](const TimedPose& a, const TimedPose& b) { return a.time_s < b.time_s; });
  return poses;
}

std::size_t count_listed_frames(std::string_view text) {
  std::size_t frames = 0;
  for_each_line(text, [&](std::size_t, std::string_view) { ++frames; });
  return frames;
}

}  // namespace onemap::evaluation
