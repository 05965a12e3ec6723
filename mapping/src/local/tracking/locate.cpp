#include "mapper_impl.hpp"

#include <algorithm>

namespace onemap::mapping {

void LocalMapper::Impl::detect(const hal::FrameView& frame) {
  begin(Step::gray);
  to_gray(frame.rgb, gray);
  begin(Step::features);
  const GrayView view{gray.data(), intrinsics.width, intrinsics.height, intrinsics.width};
  if (surf)
    surf->detect(view, current.set);
  else
    orb->detect(view, current.set);
  attach_geometry(current, frame.depth, rays, intrinsics.depth_scale);
}

// Eq. (5) and figure 7: the frame's cloud, voxel-grid downsampled, as ICP's source.
void LocalMapper::Impl::make_source(const hal::FrameView& frame) {
  begin(Step::cloud);
  std::size_t n = to_points(frame.depth, rays, intrinsics.depth_scale, kCloudStride, raw_points);
  n = static_cast<std::size_t>(std::remove_if(raw_points.begin(), raw_points.begin() + static_cast<std::ptrdiff_t>(n),
                                              [](const Vector3f& p) { return p.z() > kCloudFar_m; }) -
                               raw_points.begin());
  source_count = voxel_grid.downsample({raw_points.data(), n}, source);
}

// Section 3 for two images: mutual nearest neighbours, fundamental matrix (eq. 6), coherent depths, 3D RANSAC.
TrackReason LocalMapper::Impl::relative_pose(const FeatureFrame& other, FrameReport& report, Pose& T_other_current) {
  begin(Step::match);
  matched = true;
  const auto found = matcher.match(current.set, other.set);
  matches.assign(found.begin(), found.end());
  kept.assign(matches.size(), 0);
  report.matches = static_cast<int>(matches.size());
  if (matches.size() < 15) return TrackReason::too_few_matches;

  begin(Step::fundamental);
  rays_r.clear();
  rays_s.clear();
  for (const Match& m : matches) {
    rays_r.push_back(other.ray[m.b]);
    rays_s.push_back(current.ray[m.a]);
  }
  Matrix3d F;
  if (!fundamental.estimate(rays_r, rays_s, kept, F).ok()) return TrackReason::fundamental_failed;

  begin(Step::ransac);
  points_r.clear();
  points_s.clear();
  pair_of.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!kept[i]) continue;
    kept[i] = 0;  // kept until the 3D RANSAC says so
    if (!other.has_depth(matches[i].b) || !current.has_depth(matches[i].a)) continue;
    points_r.push_back(other.point(matches[i].b));
    points_s.push_back(current.point(matches[i].a));
    pair_of.push_back(static_cast<std::uint16_t>(i));
  }
  if (points_r.size() < 12) return TrackReason::depth_incoherent;
  coherent.assign(points_r.size(), 0);
  if (!rigid.estimate(points_r, points_s, coherent, T_other_current).ok()) return TrackReason::ransac_failed;
  for (std::size_t i = 0; i < coherent.size(); ++i) kept[pair_of[i]] = coherent[i];
  return TrackReason::ok;
}

// ICP of the frame's cloud against the reference keyframe's; its answer is a prior for the refinement if it agrees with
// the guess.
std::optional<PosePrior> LocalMapper::Impl::align_depth(const Pose& T_camera_world) {
  begin(Step::icp);
  const Pose T_reference_world = map.keyframe(reference).T_camera_world;
  const Pose guess = T_reference_world * T_camera_world.inverse();
  const IcpResult r = icp.align(*target, {source.data(), source_count}, guess);
  if (!r.converged) return std::nullopt;
  const Pose off = guess.inverse() * r.T_target_source;
  if (off.t.squaredNorm() > kIcpAgree_m * kIcpAgree_m || rotation_cosine(off.R) < kIcpAgreeCosine) return std::nullopt;
  PosePrior prior;
  prior.T_camera_world = r.T_target_source.inverse() * T_reference_world;
  prior.information = kIcpWeight * information_of_inverse(r.information, r.T_target_source);
  return prior;
}

TrackReason LocalMapper::Impl::refine(FrameReport& report, Pose& T_camera_world) {
  const auto prior = align_depth(T_camera_world);
  begin(Step::refine);
  search.index(current);
  SearchConfig near;
  if (current.set.kind == DescriptorKind::orb) near.max_distance = 60;
  search.find(map, local_landmarks, T_camera_world, near, current);
  observations.clear();
  observation_feature.clear();
  for (std::size_t i = 0; i < current.size(); ++i) {
    if (current.landmark[i] < 0) continue;
    const double size = std::max(1.0, static_cast<double>(current.set.keypoints[i].size_px) / 24.0);
    observations.push_back({map.landmark(current.landmark[i]).p_world,
                            {current.ray[i], current.has_depth(i) ? 1 / current.depth_m[i] : 0.0, 1 / (size * size)},
                            true});
    observation_feature.push_back(static_cast<std::uint32_t>(i));
  }
  const RefineResult r = refine_pose(observations, focal_px, prior ? &*prior : nullptr, T_camera_world);
  report.inliers = r.inliers;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    std::int32_t& id = current.landmark[observation_feature[i]];
    if (observations[i].inlier)
      ++map.landmark(id).found;
    else
      id = -1;
  }
  return r.inliers >= kMinLandmarkInliers ? TrackReason::ok : TrackReason::ransac_failed;
}

// Tries to place the current frame by one other image whose pose is known.
TrackReason LocalMapper::Impl::place(const FeatureFrame& other, const Pose& T_other_world, FrameReport& report,
                                     Pose& T_camera_world) {
  Pose T_other_current;
  if (const auto reason = relative_pose(other, report, T_other_current); reason != TrackReason::ok) return reason;
  T_camera_world = T_other_current.inverse() * T_other_world;  // eq. (7)
  std::fill(current.landmark.begin(), current.landmark.end(), -1);
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (kept[i]) current.landmark[matches[i].a] = other.landmark[matches[i].b];
  return refine(report, T_camera_world);
}

TrackReason LocalMapper::Impl::place_by_keyframe(std::size_t slot, FrameReport& report, Pose& T_camera_world) {
  const MapKeyframe& k = map.keyframe(slot);
  matched_previous = false;
  matched_slot = slot;
  matched_time = k.time;
  return place(k.features, k.T_camera_world, report, T_camera_world);
}

TrackReason LocalMapper::Impl::locate(FrameReport& report, Pose& T_camera_world) {
  matched_previous = true;
  matched_time = previous_time;
  TrackReason reason = place(previous, T_previous_world, report, T_camera_world);
  if (reason == TrackReason::ok) return reason;
  const std::size_t first_reference = reference;
  if (place_by_keyframe(reference, report, T_camera_world) == TrackReason::ok) return TrackReason::ok;
  if (state != TrackState::lost) return reason;
  for (std::size_t tries = 0, looked = 0; tries < kRelocalizationTries && looked < map.keyframe_capacity(); ++looked) {
    const std::size_t slot = relocalization_next;
    relocalization_next = (relocalization_next + 1) % map.keyframe_capacity();
    if (!map.keyframe(slot).used || slot == first_reference) continue;
    ++tries;
    use_reference(slot);
    if (place_by_keyframe(slot, report, T_camera_world) == TrackReason::ok) return TrackReason::ok;
  }
  use_reference(first_reference);
  return reason;
}

}  // namespace onemap::mapping
