// Depth that is measured later than colour is fused where the camera was then.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mapping/local/local_mapper.hpp"
#include "mapping/local/surface.hpp"
#include "support/stream.hpp"
#include "support/true_surface.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kFrames = 160;

struct Errors {
  double surface_m = 0;  // of all that is open at the end, root mean square of the distance from the true room
  double path_m = 0;     // root mean square of the way from where the camera was
};

// told: the mapper is told when depth was measured.
Errors errors(const std::string& address, bool told) {
  test::Stream stream(address);
  LocalMapper mapper({}, stream.intrinsics());
  const Pose T_world_robot = test::truth_pose(stream.truth.front());
  double squares = 0;
  std::size_t n = 0;
  for (; n < kFrames; ++n) {
    const auto frame = stream.next();
    hal::FrameView view = frame->view();
    if (!told) view.depth_time = view.colour_time;
    const FrameReport report = mapper.process(view);
    // The first frame waits for the second, until it is known how the camera moves.
    EXPECT_EQ(report.state, told && n == 0 ? TrackState::starting : TrackState::tracking);
    const Vector3d truth = test::truth_pose(stream.truth[n]).t;
    squares += ((T_world_robot * report.T_robot_camera).t - truth).squaredNorm();
  }
  TriangleMesh all;
  mapper.for_each_submap([&](const SubmapAnchor& anchor, const VoxelMap& map) {
    const Pose T_world_anchor = T_world_robot * anchor.T_anchor_robot.inverse();
    const TriangleMesh part = extract_mesh(map);
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (const Vector3f& p : part.vertices) all.vertices.push_back((T_world_anchor * p.cast<double>()).cast<float>());
    for (const auto& t : part.triangles) all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  });
  const auto options = hal::simulated::parse_options(*hal::parse_camera_address(address));
  const auto scene = hal::simulated::build_scene(options->scene, options->seed);
  return {test::judge(all, scene, test::PointSet(0.01)).rms_m, std::sqrt(squares / static_cast<double>(kFrames))};
}

// Placed, too: the features' points and the cloud are where the camera was when colour was seen.
TEST(DepthTime, ASurfaceIsPlacedAndFusedWhereTheCameraWasThen) {
  Errors told, untold;
  for (const int late_ms : {-30, 30}) {
    const std::string address = fmt::format("simulated:living-room?frames=400&seed=3&depth_late_ms={}", late_ms);
    const Errors with = errors(address, true), without = errors(address, false);
    fmt::print("{} ms: surface {:.2f} mm, untold {:.2f} mm; path {:.2f} mm, untold {:.2f} mm\n", late_ms,
               with.surface_m * 1e3, without.surface_m * 1e3, with.path_m * 1e3, without.path_m * 1e3);
    told.surface_m += with.surface_m, untold.surface_m += without.surface_m;
    told.path_m += with.path_m, untold.path_m += without.path_m;
  }
  EXPECT_LT(told.surface_m, 0.7 * untold.surface_m);
  EXPECT_LT(told.path_m, 0.7 * untold.path_m);
}

}  // namespace
}  // namespace onemap::mapping
