#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "landmark_map.hpp"
#include "mapping/local/mapper_config.hpp"
#include "reprojection.hpp"

namespace onemap::mapping {

inline constexpr std::size_t kWindow = 8;  // keyframes whose poses are free
static_assert(kMinKeyframes == kWindow + 2, "the pool holds the window, the reference and the one that is being added");
inline constexpr std::size_t kFixedMost = 12;  // further keyframes that hold the landmarks in place

// Bundle adjustment of the last keyframes and their landmarks (Levenberg-Marquardt, landmarks eliminated by the Schur
// complement, Huber weights). Memory is taken in the constructor.
class WindowAdjuster {
 public:
  WindowAdjuster(std::size_t max_landmarks, std::size_t max_observations);
  // free_slots: at most kWindow keyframes that move; the map's other keyframes that see the same landmarks stay. With
  // none of these the first free keyframe stays. Observations that do not fit in the end are unlinked.
  void adjust(LandmarkMap& map, std::span<const std::size_t> free_slots, double focal_px);
  std::size_t bytes() const;

 private:
  struct Obs {
    Observation o;
    std::int32_t pose;  // 0..kWindow-1 free, else kWindow + index of a fixed one
    std::uint32_t feature;
  };
  struct Point {
    Vector3d p;
    std::int32_t id;
    std::uint32_t begin, end;  // observations
  };
  using Matrix36 = Eigen::Matrix<double, 3, 6>;

  void gather(LandmarkMap& map, std::span<const std::size_t> free_slots);
  void gather_free(LandmarkMap& map, std::span<const std::size_t> free_slots, std::uint32_t mark);
  void gather_fixed(LandmarkMap& map, std::uint32_t mark);
  void sort_by_point();
  void add_observations(LandmarkMap& map, std::size_t slot, std::int32_t pose, bool create);
  double cost(double focal_px, const std::array<Pose, kWindow>& poses, bool trial) const;
  void linearize(double focal_px, double lambda);
  void hold_by_depth();
  Matrix3d linearize_point(std::size_t j, double focal_px);
  void eliminate_point(std::size_t j);
  bool solve();
  const Pose& pose_of(std::int32_t index, const std::array<Pose, kWindow>& poses) const;
  void drop_outliers(LandmarkMap& map, double focal_px);

  std::size_t free_ = 0, fixed_ = 0;
  bool first_is_fixed_ = false;
  std::array<std::size_t, kWindow> free_slot_{};
  std::array<std::size_t, kFixedMost> fixed_slot_{};
  std::array<Pose, kWindow> pose_, trial_pose_;
  std::array<std::optional<PosePrior>, kWindow> depth_;
  std::array<Pose, kFixedMost> fixed_pose_;
  std::vector<Point> points_;
  std::vector<Vector3d> trial_, step_b_;
  std::vector<Matrix3d> inverse_V_;
  std::vector<Obs> gathered_, observations_;
  std::vector<std::uint32_t> point_of_;
  std::vector<Matrix36> W_;  // per observation: J_p^T w J_c
  Eigen::Matrix<double, 6 * kWindow, 6 * kWindow> S_;
  Eigen::Matrix<double, 6 * kWindow, 1> g_, delta_;
};

}  // namespace onemap::mapping
