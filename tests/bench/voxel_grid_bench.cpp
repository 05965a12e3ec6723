// Voxel-grid downsampling of 800,000 points (frames of a recording in the world frame) at 2 cm: ours and PCL's.
// Run it on one core: taskset -c 0.
#include <fmt/core.h>

#include <chrono>

#ifdef ONEMAP_HAVE_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#endif

#include "mapping/local/ray_table.hpp"
#include "mapping/local/voxel_grid.hpp"
#include "support/tum_recording.hpp"

using namespace onemap;
using namespace onemap::mapping;

namespace {

constexpr float kLeaf_m = 0.02f;
constexpr std::size_t kPoints = 800000;
constexpr int kRepetitions = 21;

template <class Work>
double median_ms(Work work) {
  std::vector<double> ms;
  for (int i = 0; i < kRepetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(ms.begin(), ms.end());
  return ms[ms.size() / 2];
}

std::vector<Vector3f> world_points(const test::TumRecording& recording) {
  const RayTable rays(recording.intrinsics());
  std::vector<Vector3f> points, frame(640 * 480);
  for (std::size_t i = 50; i < recording.depths().size() && points.size() < kPoints; i += 150) {
    Pose T_world_camera;
    if (!recording.truth(i, T_world_camera)) continue;
    const std::size_t n = to_points(recording.depth(i), rays, recording.intrinsics().depth_scale, {}, frame);
    for (std::size_t j = 0; j < n && points.size() < kPoints; ++j) {
      points.emplace_back((T_world_camera * frame[j].cast<double>()).cast<float>());
    }
  }
  return points;
}

}  // namespace

int main(int argc, char** argv) {
  const test::TumRecording recording(argc > 1 ? argv[1] : ONEMAP_SHARED_DIR "/data/fr1_xyz");
  if (!recording.ok()) {
    fmt::print(stderr, "no recording\n");
    return 1;
  }
  const auto points = world_points(recording);
  VoxelGrid grid(kLeaf_m, points.size());
  std::vector<Vector3f> out(points.size());
  std::size_t n = 0;
  fmt::print("{} points, leaf {} m, medians of {}\n", points.size(), kLeaf_m, kRepetitions);
  const double ours_ms = median_ms([&] { n = grid.downsample(points, out); });
  fmt::print("onemap VoxelGrid {:7.2f} ms {:7} points out, {:.1f} MB\n", ours_ms, n,
             static_cast<double>(grid.bytes()) * 1e-6);
#ifdef ONEMAP_HAVE_PCL
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (const Vector3f& p : points) cloud->push_back({p.x(), p.y(), p.z()});
  pcl::PointCloud<pcl::PointXYZ> down;
  const double pcl_ms = median_ms([&] {
    pcl::VoxelGrid<pcl::PointXYZ> peer;
    peer.setLeafSize(kLeaf_m, kLeaf_m, kLeaf_m);
    peer.setInputCloud(cloud);
    peer.filter(down);
  });
  fmt::print("PCL VoxelGrid    {:7.2f} ms {:7} points out\n", pcl_ms, down.size());
#endif
}
