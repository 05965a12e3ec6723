// onemap's mapper on a Kinect's isochronous streams: the real libfreenect and libusb, and a virtual Kinect that is
// pulled out and plugged in again on the way.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "virtual_kinect.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

constexpr int kPictures = 24, kPulledOutAt = 12;
const std::string kRoom = "simulated:living-room?robot=1&robots=3&seed=3&frames=" + std::to_string(kPictures);

using Way = std::map<std::size_t, mapping::Vector3d>;  // by picture

mapping::LocalMapperConfig small_map() {
  mapping::LocalMapperConfig config;
  config.max_keyframes = 40;
  return config;
}

Way simulated_way() {
  const auto camera = std::move(open_simulated(*parse_camera_address(kRoom))).value();
  mapping::LocalMapper mapper(small_map(), camera->intrinsics(), camera->depth_noise());
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  Way way;
  for (std::size_t i = 0; camera->grab(frame, 0ms) == Grab::frame; ++i)
    way[i] = mapper.process(frame.view()).T_robot_camera.t;
  return way;
}

TEST(KinectStreams, ARoomIsMappedAsThroughTheSimulatedCameraAndGoesOnAfterThePlugWasPulled) {
  const test::Film film = test::Film::shoot(kRoom, test::KinectDevice::develop);
  test::MockBus bus;
  test::VirtualKinect kinect(bus, 1, film, "KINECT01");
  kinect.plug();
  auto opened = open_libusb(*parse_camera_address("libusb:"));
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  test::OnDemand camera(std::move(*opened), kinect);
  mapping::LocalMapper mapper(small_map(), camera.intrinsics(), camera.depth_noise());
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  Way way;
  int away = 0;
  for (int tries = 0; way.size() < kPictures && tries < 2000; ++tries) {
    const Grab grab = camera.grab(frame, 20ms);
    if (grab == Grab::gone && ++away == 3) kinect.plug();
    if (grab != Grab::frame) continue;
    const auto report = mapper.process(frame.view());
    EXPECT_EQ(report.state, mapping::TrackState::tracking) << kinect.picture();
    way[kinect.picture()] = report.T_robot_camera.t;
    if (way.size() == kPulledOutAt) kinect.unplug();
  }
  EXPECT_GE(away, 3) << "it was gone";
  ASSERT_EQ(way.size(), std::size_t{kPictures});
  double squares = 0;
  for (const auto& [picture, position] : simulated_way()) squares += (way.at(picture) - position).squaredNorm();
  EXPECT_LT(std::sqrt(squares / kPictures), 0.002);
}

}  // namespace
}  // namespace onemap::hal
