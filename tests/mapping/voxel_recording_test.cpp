// The voxel map on a real recording with its ground-truth poses: the surface must agree with depth images it never saw.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "hal/lens.hpp"
#include "mapping/local/surface.hpp"
#include "support/tum_recording.hpp"

namespace onemap::mapping {
namespace {

struct Posed {
  std::vector<std::uint16_t> depth;
  Pose T_world_camera;
};

std::vector<Posed> load(const test::TumRecording& recording, std::size_t first, std::size_t step) {
  std::vector<Posed> out;
  for (std::size_t i = first; i < recording.depths().size(); i += step) {
    Posed frame;
    if (!recording.truth(i, frame.T_world_camera)) continue;
    frame.depth = recording.depth(i);
    if (!frame.depth.empty()) out.push_back(std::move(frame));
  }
  return out;
}

// How far before or behind the measured depth world points appear in an image, where they are near it at all (the
// others are hidden behind something): the median, metres.
double median_residual(const std::vector<Vector3d>& points, const Posed& frame, const hal::Intrinsics& k) {
  std::vector<double> out;
  const Pose T_camera_world = frame.T_world_camera.inverse();
  for (const Vector3d& point : points) {
    const Vector3d p = T_camera_world * point;
    if (p[2] < 0.4 || p[2] > 2.0) continue;
    const hal::Point2 px = hal::pixel_of(k, {p[0] / p[2], p[1] / p[2]});
    const int u = static_cast<int>(std::lround(px.x)), v = static_cast<int>(std::lround(px.y));
    if (u < 0 || v < 0 || u >= k.width || v >= k.height) continue;
    const double z = frame.depth[static_cast<std::size_t>(v * k.width + u)] / k.depth_scale;
    if (z > 0 && std::abs(z - p[2]) < 0.1) out.push_back(std::abs(z - p[2]));
  }
  std::sort(out.begin(), out.end());
  return out.size() < 1000 ? 1.0 : out[out.size() / 2];
}

// A frame's own points in the world, every fourth pixel.
std::vector<Vector3d> points_of(const Posed& frame, const RayTable& rays, double depth_scale) {
  std::vector<Vector3f> camera(frame.depth.size());
  camera.resize(to_points(frame.depth, rays, depth_scale, {.stride = 4}, camera));
  std::vector<Vector3d> out;
  for (const Vector3f& p : camera) out.push_back(frame.T_world_camera * Vector3d(p.cast<double>()));
  return out;
}

// The truth's clock and the camera's calibration alone move single images of this recording by 0.3 cm to 3 cm against
// each other, so the measure is how well other single images predict the same image: the map must do no worse.
TEST(VoxelRecording, SurfacePredictsUnseenImagesNoWorseThanOtherImagesDo) {
  const std::filesystem::path folder = std::filesystem::path(ONEMAP_SHARED_DIR) / "data" / "fr1_xyz";
  if (!std::filesystem::exists(folder / "groundtruth.txt")) GTEST_SKIP() << "the recording " << folder << " is missing";
  const test::TumRecording recording(folder);
  const hal::Intrinsics& k = recording.intrinsics();
  const RayTable rays(k);
  const auto frames = load(recording, 0, 20), held_out = load(recording, 10, 100);
  ASSERT_GE(held_out.size(), 5u);
  VoxelMap map{VoxelMapConfig{}};
  for (const Posed& frame : frames) map.integrate({{}, {}, 0, &k, {}, frame.depth}, rays, frame.T_world_camera);
  EXPECT_EQ(map.counters().blocks_refused, 0u);
  std::vector<Vector3d> surface;
  for (const Vector3f& v : extract_mesh(map, 16).vertices) surface.push_back(v.cast<double>());
  ASSERT_GT(surface.size(), 10000u);
  double of_map = 0, of_images = 0;
  for (const Posed& unseen : held_out) {
    of_map += median_residual(surface, unseen, k) / static_cast<double>(held_out.size());
    for (const Posed& other : frames)
      of_images += median_residual(points_of(other, rays, k.depth_scale), unseen, k) /
                   static_cast<double>(held_out.size() * frames.size());
  }
  RecordProperty("of_map_m", std::to_string(of_map));
  RecordProperty("of_images_m", std::to_string(of_images));
  EXPECT_LT(of_map, 0.02) << "one voxel";
  EXPECT_LT(of_map, of_images);
}

}  // namespace
}  // namespace onemap::mapping
