#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "landmark_map.hpp"

namespace onemap::mapping {

struct SearchConfig {
  double radius_px = 12;
  std::int32_t max_distance = 4000;  // squared, of int8 SURF descriptors; see FeatureFrame's kind for ORB
  float max_ratio = 0.9f;            // best / second best (distances, not squared)
};

// Finds landmarks of the map in a frame whose pose is nearly known: projects each and looks for the best descriptor
// near by. Memory is taken in the constructor.
class GuidedSearch {
 public:
  GuidedSearch(const hal::Intrinsics& intrinsics, std::size_t max_features);
  // Sorts the frame's features into image cells; before the calls of find() for that frame.
  void index(const FeatureFrame& frame);
  // Sets frame.landmark for features that were free and match a landmark of ids; returns how many. Counts visible.
  int find(LandmarkMap& map, std::span<const std::int32_t> ids, const Pose& T_camera_robot, const SearchConfig& config,
           FeatureFrame& frame);
  // Landmarks that the last find() looked for well inside the image, where a feature of any size can be found.
  int expected() const { return expected_; }

 private:
  void nearest(const Landmark& landmark, double u, double v, const SearchConfig& config, const FeatureFrame& frame,
               int& feature, std::int32_t& distance) const;
  static constexpr int kCell_px = 20;
  static constexpr double kMargin = 0.075;  // of the image's width
  double fx_, fy_, cx_, cy_;
  int width_, height_;  // of the image
  int columns_, rows_;
  int expected_ = 0;
  std::vector<std::uint16_t> cell_begin_, order_;
  std::vector<Eigen::Vector2f> pixel_;                // undistorted pixel of each feature
  std::vector<std::int32_t> claim_, claim_distance_;  // per feature: landmark that claims it
};

}  // namespace onemap::mapping
