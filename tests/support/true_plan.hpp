#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "support/simulated_keyframes.hpp"

// Simulated rooms as a floor plan should show them. Needs the simulated camera's own headers.
namespace onemap::test {

namespace simulated = hal::simulated;

// The squares of the room's own floor plan on which something stands between two heights, from its formulas.
class TruePlan {
 public:
  TruePlan(const simulated::Scene& scene, double low_m, double high_m) : low_m_(low_m), high_m_(high_m) {
    for (const simulated::Patch& patch : scene.patches) {
      const simulated::Vec3 middle =
          patch.origin + 0.5 * patch.size_u * patch.axis_u + 0.5 * patch.size_v * patch.axis_v;
      for (double u = 0; u <= patch.size_u; u += kStep_m)
        for (double v = 0; v <= patch.size_v; v += kStep_m) {
          const simulated::Vec3 p = patch.origin + u * patch.axis_u + v * patch.axis_v, off = p - middle;
          if (!patch.round || dot(off, off) <= patch.size_u * patch.size_u / 4) add(p);
        }
    }
    for (const simulated::Curved& c : scene.curved)
      for (double turn = 0; turn < 1; turn += 0.02)
        for (double up = c.height > 0 ? 0 : -1; up <= 1; up += c.height > 0 ? kStep_m / c.height : 0.1) {
          const double r = c.height > 0 ? c.radius : c.radius * std::sqrt(1 - up * up);
          const double z = c.height > 0 ? up * c.height : up * c.radius;
          add(c.base + simulated::Vec3{r * simulated::cos_turns(turn), r * simulated::sin_turns(turn), z});
        }
  }
  // Whether something stands within `near_m` of a place.
  bool stands(double x, double y, double near_m) const {
    const int reach = static_cast<int>(near_m / kStep_m);
    for (int j = -reach; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i)
        if (const std::size_t at = index(x + i * kStep_m, y + j * kStep_m); at < taken_.size() && taken_[at] != 0)
          return true;
    return false;
  }

 private:
  static constexpr double kStep_m = 0.01, kHalf_m = 10;
  static constexpr int kSide = static_cast<int>(2 * kHalf_m / kStep_m);
  static std::size_t index(double x, double y) {
    const auto i = static_cast<long>(std::floor((x + kHalf_m) / kStep_m));
    const auto j = static_cast<long>(std::floor((y + kHalf_m) / kStep_m));
    return i < 0 || j < 0 || i >= kSide || j >= kSide ? SIZE_MAX : static_cast<std::size_t>(j * kSide + i);
  }
  void add(const simulated::Vec3& p) {
    if (p.z < low_m_ || p.z > high_m_) return;
    if (const std::size_t at = index(p.x, p.y); at < taken_.size()) taken_[at] = 1;
  }
  const double low_m_, high_m_;
  std::vector<std::uint8_t> taken_ = std::vector<std::uint8_t>(static_cast<std::size_t>(kSide) * kSide);
};

struct Room {
  const char* name;
  simulated::SceneName scene;
  double size_x, size_y;  // between its walls
  int robots;             // that walk in it
};

// What of a plan is as it should be.
struct Score {
  int free = 0, free_wrong = 0, occupied = 0, occupied_wrong = 0, outside = 0;
  double right() const {
    const int decided = free + occupied;
    return decided == 0 ? 0 : 1 - static_cast<double>(free_wrong + occupied_wrong) / decided;
  }
};

inline Score score_of(const mapping::FloorPlan& plan, const mapping::Pose& T_world_plan, const TruePlan& truth,
                      const Room& room) {
  Score score;
  for (int j = 0; j < plan.height; ++j)
    for (int i = 0; i < plan.width; ++i) {
      const mapping::Vector3d p = T_world_plan * mapping::Vector3d(plan.origin_x_m + (i + 0.5) * plan.cell_m,
                                                                   plan.origin_y_m + (j + 0.5) * plan.cell_m, 1);
      const mapping::Space space = plan.at(i, j);
      const double out = std::max(std::abs(p.x()) - room.size_x / 2, std::abs(p.y()) - room.size_y / 2);
      if (space == mapping::Space::empty) ++score.free, score.free_wrong += out > 0 || truth.stands(p.x(), p.y(), 0.02);
      if (space == mapping::Space::occupied)
        ++score.occupied, score.occupied_wrong += !truth.stands(p.x(), p.y(), 0.05);
      score.outside += space != mapping::Space::unknown && out > 0.10;
    }
  return score;
}

// Keyframes of all robots that walk in a room, as one map in the frame of the first.
inline SimulatedKeyframes all_keyframes(const Room& room, const std::string& options) {
  SimulatedKeyframes all;
  for (int robot = 1; robot <= room.robots; ++robot) {
    auto one = simulated_keyframes(
        "simulated:" + std::string(room.name) + "?" + options + "&width=320&height=240&robot=" + std::to_string(robot),
        3);
    if (robot == 1) all.T_world_map = one.T_world_map;
    const mapping::Pose T_map_robot = all.T_world_map.inverse() * one.T_world_map;
    for (const mapping::Pose& pose : one.poses) all.poses.push_back(T_map_robot * pose);
    std::ranges::move(one.bodies, std::back_inserter(all.bodies));
    std::ranges::move(one.grids, std::back_inserter(all.grids));
  }
  return all;
}

}  // namespace onemap::test
