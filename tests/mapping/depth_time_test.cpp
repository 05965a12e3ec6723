// Depth that is measured later than colour is fused where the camera was then.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mapping/local/local_mapper.hpp"
#include "mapping/local/surface.hpp"
#include "support/stream.hpp"
#include "support/true_surface.hpp"

namespace onemap::mapping {
namespace {

// Of all that is open at the end, root mean square of the distance from the true room, metres; `told`: the mapper is
// told when depth was measured.
double surface_error(const std::string& address, bool told) {
  test::Stream stream(address);
  LocalMapper mapper({}, stream.intrinsics());
  while (const auto frame = stream.next()) {
    hal::FrameView view = frame->view();
    if (!told) view.depth_time = view.colour_time;
    EXPECT_EQ(mapper.process(view).state, TrackState::tracking);
  }
  TriangleMesh all;
  const Pose T_world_robot = test::truth_pose(stream.truth.front());
  mapper.for_each_submap([&](const SubmapAnchor& anchor, const VoxelMap& map) {
    const Pose T_world_anchor = T_world_robot * anchor.T_anchor_robot.inverse();
    const TriangleMesh part = extract_mesh(map);
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (const Vector3f& p : part.vertices) all.vertices.push_back((T_world_anchor * p.cast<double>()).cast<float>());
    for (const auto& t : part.triangles) all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  });
  const auto options = hal::simulated::parse_options(*hal::parse_camera_address(address));
  const auto scene = hal::simulated::build_scene(options->scene, options->seed);
  return test::judge(all, scene, test::PointSet(0.01)).rms_m;
}

TEST(DepthTime, ASurfaceIsFusedWhereTheCameraWasThen) {
  for (const int late_ms : {-30, 30}) {
    const std::string address =
        fmt::format("simulated:living-room?frames=45&fps=10&width=320&height=240&depth_late_ms={}", late_ms);
    const double told = surface_error(address, true), untold = surface_error(address, false);
    std::printf("%d ms: %.2f mm, untold %.2f mm\n", late_ms, told * 1e3, untold * 1e3);
    EXPECT_LT(told, 0.6 * untold) << late_ms;
  }
}

}  // namespace
}  // namespace onemap::mapping
