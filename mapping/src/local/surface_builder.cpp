#include "surface_builder.hpp"

#include "mapping/local/make_submap.hpp"

namespace onemap::mapping {

namespace {
constexpr std::uint64_t kLookInterval = 15;  // fused frames between two looks for settled blocks
constexpr std::uint64_t kSettledAge = 10;    // fused frames without a change after which a block has settled
constexpr std::size_t kSubmapBlocks = 256;   // at most, in one record
}  // namespace

SurfaceBuilder::SurfaceBuilder(const SurfaceBuilderConfig& config)
    : voxels_(config.map), gate_(config.min_motion_m, config.min_motion_deg) {}

bool SurfaceBuilder::integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_camera_robot) {
  const Pose T_robot_camera = T_camera_robot.inverse();
  if (any_ && gate_.within(T_fused_robot_ * T_robot_camera)) return false;
  voxels_.integrate(frame, rays, T_robot_camera);
  T_fused_robot_ = T_camera_robot;
  any_ = true;
  return true;
}

// Whether it is time: every some frames, until a look finds nothing more.
bool SurfaceBuilder::looks() {
  const std::uint64_t fused = voxels_.counters().integrated_frames;
  if (fused >= looked_ + kLookInterval) {
    looked_ = fused;
    looking_ = true;
  }
  return looking_ || finished_;
}

bool SurfaceBuilder::take_submap(SubmapRecord& out) {
  if (!looks()) return false;
  const auto blocks = voxels_.take_settled(finished_ ? 0 : kSettledAge, kSubmapBlocks);
  looking_ = !blocks.empty();
  if (looking_) out = make_submap(voxels_, blocks);
  return looking_;
}

}  // namespace onemap::mapping
