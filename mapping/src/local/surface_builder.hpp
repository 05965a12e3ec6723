#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "local/exposure.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/submap_anchor.hpp"
#include "mapping/local/surface_counters.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/submap.hpp"
#include "submap_shelf.hpp"
#include "tracking/motion_gate.hpp"

namespace onemap::mapping {

struct SurfaceBuilderConfig {
  VoxelMapConfig map;          // its budget is that of all open submaps together
  double min_motion_m = 0.03;  // frames that moved less than both since the last fused one are not fused
  double min_motion_deg = 2.0;
  std::size_t shelf_bytes = 16u << 20;  // for submaps that the camera has left
};

// The robot's surface, as submaps: each lies in the frame of a keyframe, its anchor, so that a keyframe that moves
// takes its surface with it. A frame is fused into the submap of its reference keyframe's anchor. A few submaps are
// open, in one pool of blocks; one that the camera has left goes to the shelf once all its blocks have been handed out,
// and comes back from there. Memory is taken in the constructor, but for submap records.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const SurfaceBuilderConfig& config);

  // Which of these anchors' submaps a new keyframe belongs to; none: it has to be an anchor itself.
  std::optional<SubmapAnchor> choose(const Pose& T_camera_robot, std::span<const SubmapAnchor> near) const;
  // The paper, end of section 3: false when the camera moved too little since the last frame that was added.
  bool integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_camera_robot,
                 const SubmapAnchor& anchor);
  void place(const SubmapAnchor& anchor);  // it has moved in the robot's frame
  void finish() { finished_ = true; }      // no more frames: all that changed has settled

  // Blocks of one submap that have settled since they were last handed out; false when there is none (yet). Allocates.
  bool take_submap(SubmapRecord& out);

  // Every submap that is known here, the shelf's and the open ones, by the map it is in. Not for the frame path.
  void for_each(const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const;
  SurfaceCounters counters() const;
  std::size_t blocks() const;  // in use, of the open submaps
  std::size_t bytes() const;
  double color_gain() const { return exposure_.gain() / 256.0; }  // what the last fused frame's colours came on with

 private:
  // Two that the camera goes to and fro between, and two that are on their way to the shelf.
  static constexpr std::size_t kOpen = 4, kKept = 2;
  struct Open {
    explicit Open(VoxelMap map) : voxels(std::move(map)) {}
    VoxelMap voxels;
    SubmapAnchor anchor;
    bool used = false, leaving = false;
    std::uint64_t last_fused = 0;  // frame
    std::uint64_t looked = 0;      // fused frames when settled blocks were last looked for,
    bool looking = false;          // and there may be more of them
  };
  Open* find(std::uint32_t anchor);
  bool is_open(std::uint32_t anchor) const;
  bool crowded(std::uint32_t anchor) const;
  Open* open(const SubmapAnchor& anchor);
  void leave_oldest(const Open& current);
  bool looks(Open& submap) const;
  void shelve(Open& submap);
  void measure_exposure(const Open& submap, const hal::FrameView& frame, const RayTable& rays,
                        const Pose& T_robot_camera);
  static void add_counts(const VoxelMapCounters& submap, SurfaceCounters& to);

  std::vector<Open> open_;  // kOpen
  SubmapShelf shelf_;
  Exposure exposure_;
  MotionGate reach_, gate_;
  bool any_ = false;              // frame was fused
  Pose T_fused_robot_;            // the last one,
  std::uint32_t fused_into_ = 0;  // into the submap of this anchor
  SurfaceCounters counters_;
  bool finished_ = false;
};

}  // namespace onemap::mapping
