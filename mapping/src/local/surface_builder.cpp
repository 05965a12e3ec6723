#include "surface_builder.hpp"

#include <algorithm>

#include "mapping/local/make_submap.hpp"

namespace onemap::mapping {

namespace {
constexpr std::uint64_t kLookInterval = 15;  // fused frames between two looks for settled blocks
constexpr std::uint64_t kSettledAge = 10;    // fused frames without a change after which a block has settled
constexpr std::size_t kSubmapBlocks = 256;   // at most, in one record

// How far a keyframe may be from its anchor. On a way with one percent of drift the surface within stays sharp to half
// a voxel, and a camera that turns on the spot makes few submaps.
constexpr double kReach_m = 1.0, kReach_deg = 45.0;

VoxelMapConfig for_looking(VoxelMapConfig config) {
  config.image_pixels = 0;
  config.resident = false;
  return config;
}
}  // namespace

SurfaceBuilder::SurfaceBuilder(const SurfaceBuilderConfig& config)
    : shelf_(config.shelf_bytes),
      exposure_(config.map.image_pixels),
      reach_(kReach_m, kReach_deg),
      gate_(config.min_motion_m, config.min_motion_deg) {
  open_.reserve(kOpen);
  open_.emplace_back(VoxelMap(config.map, kOpen));
  while (open_.size() < kOpen) open_.emplace_back(open_.front().voxels.sibling());
}

SurfaceBuilder::Open* SurfaceBuilder::find(std::uint32_t anchor) {
  const auto at = std::ranges::find_if(open_, [&](const Open& o) { return o.used && o.anchor.keyframe == anchor; });
  return at == open_.end() ? nullptr : &*at;
}

// It takes so much of the pool that the next one could not be begun beside it.
bool SurfaceBuilder::crowded(std::uint32_t anchor) const {
  return std::ranges::any_of(open_, [&](const Open& o) {
    return o.used && o.anchor.keyframe == anchor && 5 * o.voxels.used() > 2 * o.voxels.capacity();
  });
}

bool SurfaceBuilder::is_open(std::uint32_t anchor) const {
  return std::ranges::any_of(open_, [&](const Open& o) { return o.used && o.anchor.keyframe == anchor; });
}

std::optional<SubmapAnchor> SurfaceBuilder::choose(const Pose& T_camera_robot,
                                                   std::span<const SubmapAnchor> near) const {
  const SubmapAnchor* best = nullptr;
  double least = 0;
  for (const SubmapAnchor& anchor : near) {
    if ((!is_open(anchor.keyframe) && !shelf_.has(anchor.keyframe)) || crowded(anchor.keyframe)) continue;
    const Pose T_anchor_camera = anchor.T_anchor_robot * T_camera_robot.inverse();
    if (!reach_.within(T_anchor_camera)) continue;
    if (anchor.keyframe == fused_into_) return anchor;  // as long as it may
    const double far = T_anchor_camera.t.squaredNorm() - rotation_cosine(T_anchor_camera.R);
    if (best == nullptr || far < least) best = &anchor, least = far;
  }
  return best == nullptr ? std::nullopt : std::optional<SubmapAnchor>(*best);
}

bool SurfaceBuilder::integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_camera_robot,
                               const SubmapAnchor& anchor) {
  const Pose T_robot_camera = T_camera_robot.inverse();
  if (any_ && gate_.within(T_fused_robot_ * T_robot_camera)) return false;
  Open* submap = open(anchor);
  if (submap == nullptr) return ++counters_.frames_waiting, false;
  measure_exposure(*submap, frame, rays, T_robot_camera);
  hal::FrameView evened = frame;
  evened.rgb = exposure_.evened(frame.rgb);
  submap->voxels.integrate(evened, rays, anchor.T_anchor_robot * T_robot_camera);
  submap->last_fused = ++counters_.integrated_frames;
  fused_into_ = anchor.keyframe;
  T_fused_robot_ = T_camera_robot;
  any_ = true;
  if (4 * submap->voxels.room() < submap->voxels.capacity()) leave_oldest(*submap);
  return true;
}

// Beside the submap that the frame goes into, or, while that holds little of what is seen, the one before.
void SurfaceBuilder::measure_exposure(const Open& submap, const hal::FrameView& frame, const RayTable& rays,
                                      const Pose& T_robot_camera) {
  const auto beside = [&](const Open& o) {
    return brightness_ratio(o.voxels, frame, rays, o.anchor.T_anchor_robot * T_robot_camera);
  };
  auto ratio = beside(submap);
  const Open* before = any_ ? find(fused_into_) : nullptr;
  if (!ratio && before != nullptr && before != &submap) ratio = beside(*before);
  exposure_.measured(ratio);
}

// The submap of the anchor, begun or opened again if need be; nullptr while the others are still on their way out.
SurfaceBuilder::Open* SurfaceBuilder::open(const SubmapAnchor& anchor) {
  Open* submap = find(anchor.keyframe);
  if (submap == nullptr) {
    const auto unused = std::ranges::find_if(open_, [](const Open& o) { return !o.used; });
    if (unused == open_.end() || unused->voxels.room() < shelf_.blocks(anchor.keyframe)) return nullptr;
    submap = &*unused;
    submap->used = true;
    submap->looked = counters_.integrated_frames;
    if (shelf_.take(anchor.keyframe, submap->voxels))
      ++counters_.reopened;
    else
      ++counters_.submaps;
  }
  submap->anchor = anchor;
  submap->leaving = false;
  const auto kept = std::ranges::count_if(open_, [](const Open& o) { return o.used && !o.leaving; });
  if (static_cast<std::size_t>(kept) > kKept) leave_oldest(*submap);
  return submap;
}

// Of those that stay, but for the current one, that which was not fused into for longest.
void SurfaceBuilder::leave_oldest(const Open& current) {
  Open* oldest = nullptr;
  for (Open& o : open_)
    if (o.used && !o.leaving && &o != &current && (oldest == nullptr || o.last_fused < oldest->last_fused)) oldest = &o;
  if (oldest != nullptr) oldest->leaving = true;
}

void SurfaceBuilder::place(const SubmapAnchor& anchor) {
  if (Open* submap = find(anchor.keyframe))
    submap->anchor = anchor;
  else
    shelf_.place(anchor);
}

// Whether it is time: every some frames, until a look finds nothing more.
bool SurfaceBuilder::looks(Open& submap) const {
  const std::uint64_t fused = submap.voxels.counters().integrated_frames;
  if (fused >= submap.looked + kLookInterval) {
    submap.looked = fused;
    submap.looking = true;
  }
  return submap.looking || submap.leaving || finished_;
}

bool SurfaceBuilder::take_submap(SubmapRecord& out) {
  for (Open& submap : open_) {
    if (!submap.used || !looks(submap)) continue;
    const bool all = submap.leaving || finished_;
    const auto blocks = submap.voxels.take_settled(all ? 0 : kSettledAge, kSubmapBlocks);
    submap.looking = !blocks.empty();
    if (submap.looking) {
      out = make_submap(submap.voxels, blocks);
      out.anchor_keyframe = submap.anchor.keyframe;
      return true;
    }
    if (submap.leaving) shelve(submap);
  }
  return false;
}

void SurfaceBuilder::shelve(Open& submap) {
  shelf_.put(submap.anchor, submap.voxels);
  add_counts(submap.voxels.counters(), counters_);
  submap.voxels.clear();
  submap.used = submap.leaving = submap.looking = false;
}

void SurfaceBuilder::add_counts(const VoxelMapCounters& submap, SurfaceCounters& to) {
  to.blocks_refused += submap.blocks_refused;
  to.frames_short += submap.frames_short;
}

void SurfaceBuilder::for_each(const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const {
  VoxelMap scratch(for_looking(open_.front().voxels.config()));
  shelf_.for_each(scratch, fn);
  for (const Open& submap : open_)
    if (submap.used) fn(submap.anchor, submap.voxels);
}

SurfaceCounters SurfaceBuilder::counters() const {
  SurfaceCounters out = counters_;
  out.submaps_dropped = shelf_.dropped();
  for (const Open& submap : open_) add_counts(submap.voxels.counters(), out);
  return out;
}

std::size_t SurfaceBuilder::blocks() const { return open_.front().voxels.capacity() - open_.front().voxels.room(); }

std::size_t SurfaceBuilder::bytes() const {
  return open_.front().voxels.bytes() + (kOpen - 1) * open_.front().voxels.own_bytes() + shelf_.bytes() +
         exposure_.bytes();
}

}  // namespace onemap::mapping
