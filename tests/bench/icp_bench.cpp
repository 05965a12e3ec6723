// Relative poses of recorded depth frames, from the identity, against ground truth at the depth stamps: our Icp and,
// where PCL is installed, its GeneralizedIterativeClosestPoint at 5 cm on the same pairs. Run it on one core: taskset
// -c 0.
#include <fmt/core.h>

#include <chrono>

#ifdef ONEMAP_HAVE_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#endif

#include "mapping/local/icp.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/voxel_grid.hpp"
#include "support/poses.hpp"
#include "support/tum_recording.hpp"

using namespace onemap;
using namespace onemap::mapping;

namespace {

constexpr float kLeaf_m = 0.05f, kMaxRange_m = 5;
constexpr int kWidth = 160, kHeight = 120;

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

// What one system did on one gap.
struct Column {
  std::vector<double> prepare_ms, down_ms, align_ms, error_mm, error_deg;
  int bad = 0;

  void judge(const Pose& T_truth, const Pose& T) {
    const Pose error = T_truth.inverse() * T;
    error_mm.push_back(1e3 * error.t.norm());
    error_deg.push_back(test::rotation_angle(error.R) * 57.29578);
    bad += error_mm.back() > 50 || error_deg.back() > 3;
  }
  void print(const char* name, std::size_t gap) const {
    fmt::print("{:10} {:4} {:6} {:11.2f} {:8.2f} {:8.2f} {:8.2f} {:9.1f} {:9.2f} {:6}\n", name, gap, error_mm.size(),
               quantile(prepare_ms, 0.5), quantile(down_ms, 0.5), quantile(align_ms, 0.5), quantile(align_ms, 0.95),
               quantile(error_mm, 0.5), quantile(error_deg, 0.5), bad);
  }
};

class Ours {
 public:
  Pose align(const std::vector<std::uint16_t>& target, const std::vector<std::uint16_t>& source,
             const hal::Intrinsics& k, Column& column) {
    organize(source, k, kWidth, kHeight, source_);
    const double t0 = now_ms();
    organize(target, k, kWidth, kHeight, target_);
    const double t1 = now_ms();
    std::size_t n = 0;
    for (const Vector3f& p : source_.points) {
      if (p.z() > 0 && p.z() <= kMaxRange_m) valid_[n++] = p;
    }
    const std::size_t points = grid_.downsample(std::span(valid_).first(n), down_);
    const double t2 = now_ms();
    const IcpResult result = icp_.align(target_, std::span(down_).first(points), Pose{});
    column.align_ms.push_back(now_ms() - t2);
    column.prepare_ms.push_back(t1 - t0);
    column.down_ms.push_back(t2 - t1);
    return result.T_target_source;
  }

 private:
  OrganizedCloud target_, source_;
  VoxelGrid grid_{kLeaf_m, kWidth* kHeight};
  std::vector<Vector3f> valid_ = std::vector<Vector3f>(kWidth * kHeight), down_ = valid_;
  Icp icp_{{}};
};

#ifdef ONEMAP_HAVE_PCL
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr pcl_down(const std::vector<std::uint16_t>& depth, const RayTable& rays, double depth_scale, Column& column) {
  std::vector<Vector3f> points(depth.size());
  points.resize(to_points(depth, rays, depth_scale, {}, points));
  Cloud::Ptr cloud(new Cloud), down(new Cloud);
  for (const Vector3f& p : points) {
    if (p.z() <= kMaxRange_m) cloud->push_back({p.x(), p.y(), p.z()});
  }
  const double t0 = now_ms();
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(kLeaf_m, kLeaf_m, kLeaf_m);
  grid.setInputCloud(cloud);
  grid.filter(*down);
  column.down_ms.push_back(now_ms() - t0);
  return down;
}

Pose pcl_align(const Cloud::Ptr& target, const Cloud::Ptr& source, Column& column) {
  const double t0 = now_ms();
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setCorrespondenceRandomness(10);
  gicp.setMaximumIterations(20);
  gicp.setTransformationEpsilon(1e-3);
  gicp.setRotationEpsilon(0.1 / 57.29578);
  gicp.setMaxCorrespondenceDistance(0.1);
  gicp.setInputSource(source);
  gicp.setInputTarget(target);
  Cloud aligned;
  gicp.align(aligned);
  column.align_ms.push_back(now_ms() - t0);
  const Eigen::Matrix4d T = gicp.getFinalTransformation().cast<double>();
  return {T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
}
#endif

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : ONEMAP_SHARED_DIR "/data/fr1_xyz";
  const std::size_t step = argc > 2 ? std::stoul(argv[2]) : 50;
  const test::TumRecording recording(folder);
  if (!recording.ok()) {
    fmt::print(stderr, "no recording in {}\n", folder);
    return 1;
  }
  const hal::Intrinsics& k = recording.intrinsics();
  fmt::print("{:10} {:>4} {:>6} {:>11} {:>8} {:>8} {:>8} {:>9} {:>9} {:>6}\n", "system", "gap", "pairs", "organize_ms",
             "down_ms", "align_ms", "p95_ms", "error_mm", "error_deg", "bad");
  [[maybe_unused]] const RayTable rays(k);
  Ours ours;
  for (const std::size_t gap : {1u, 5u, 10u}) {
    Column our_column;
    [[maybe_unused]] Column pcl_column;
    for (std::size_t i = 0; i + gap < recording.depths().size(); i += step) {
      Pose a, b;
      if (!recording.truth(i, a) || !recording.truth(i + gap, b)) continue;
      const Pose truth = a.inverse() * b;
      const auto target = recording.depth(i), source = recording.depth(i + gap);
      our_column.judge(truth, ours.align(target, source, k, our_column));
#ifdef ONEMAP_HAVE_PCL
      const auto pcl_target = pcl_down(target, rays, k.depth_scale, pcl_column);
      const auto pcl_source = pcl_down(source, rays, k.depth_scale, pcl_column);
      pcl_column.judge(truth, pcl_align(pcl_target, pcl_source, pcl_column));
#endif
    }
    our_column.print("onemap", gap);
#ifdef ONEMAP_HAVE_PCL
    pcl_column.print("PCL GICP", gap);
#endif
  }
}
