#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "feature_frame.hpp"
#include "hal/frame.hpp"
#include "mapping/local/orb.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/step.hpp"
#include "mapping/local/surf.hpp"
#include "mapping/local/voxel_grid.hpp"

namespace onemap::mapping {

// A frame as the tracker sees it.
struct Observed {
  FrameTime time{}, depth_time{};      // the colour's, and when depth was measured
  bool lens_open = false;              // the image is no cover's: there is light, and some noise at least
  FeatureFrame features;               // their points are where the camera was when colour was seen
  std::optional<Pose> T_colour_depth;  // by how it moved between the two, as far as that was known; nothing: it did not
  std::vector<Vector3f> cloud;         // camera frame, metres; downsampled (figure 7), there, too
};

struct FrontEndConfig {
  DescriptorKind features = DescriptorKind::surf;
  int max_features = 500;
  int cloud_stride_px = 4;  // every fourth pixel in both directions becomes a point
  float cloud_leaf_m = 0.05f;
  float cloud_far_m = 5.0f;
};

// From pixels to what is tracked: local features with their rays and points (eq. 5), and a downsampled cloud. Keeps
// nothing of a frame. Memory is taken in the constructor (OpenCV's ORB alone allocates while it detects).
class FrontEnd {
 public:
  FrontEnd(const FrontEndConfig& config, const hal::Intrinsics& intrinsics);
  Observed make_observed() const;  // with the memory that observe() needs
  // T_colour_depth: how the camera moved between the two images of the frame.
  void observe(const hal::FrameView& frame, const StepHook& begin, Observed& out,
               const std::optional<Pose>& T_colour_depth = {});
  const RayTable& rays() const { return rays_; }
  std::size_t bytes() const;  // memory taken

 private:
  void detect(const hal::FrameView& frame, const StepHook& begin, const std::optional<Pose>& T_colour_depth,
              FeatureFrame& out);
  void sample_cloud(const hal::FrameView& frame, const std::optional<Pose>& T_colour_depth, std::vector<Vector3f>& out);

  FrontEndConfig config_;
  hal::Intrinsics intrinsics_;
  RayTable rays_;
  std::vector<std::uint8_t> gray_;
  std::optional<Surf> surf_;
  std::optional<Orb> orb_;
  std::vector<Vector3f> raw_points_;
  VoxelGrid voxel_grid_;
};

}  // namespace onemap::mapping
