#pragma once
#include <cstdint>

#include "hal/frame.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/submap.hpp"
#include "tracking/motion_gate.hpp"

namespace onemap::mapping {

struct SurfaceBuilderConfig {
  VoxelMapConfig map;
  double min_motion_m = 0.03;  // frames that moved less than both since the last fused one are not fused
  double min_motion_deg = 2.0;
};

// The robot's surface: which frames are fused into the voxel map, and which of its blocks have settled and may go out.
// Memory is taken in the constructor, but for submaps.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const SurfaceBuilderConfig& config);
  // The paper, end of section 3: false when the camera moved too little since the last frame that was added.
  bool integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_camera_robot);
  void finish() { finished_ = true; }  // no more frames: all that changed has settled

  // The blocks that have settled since they were last handed out, some of them; false when there is none (yet).
  // Allocates.
  bool take_submap(SubmapRecord& out);

  const VoxelMap& voxels() const { return voxels_; }

 private:
  bool looks();

  VoxelMap voxels_;
  MotionGate gate_;
  bool any_ = false;          // frame was fused
  Pose T_fused_robot_;        // the last one
  std::uint64_t looked_ = 0;  // fused frames when settled blocks were last looked for
  bool looking_ = false;      // and there may be more of them
  bool finished_ = false;
};

}  // namespace onemap::mapping
