// The Kinect backend, by the real libfreenect and libusb on a virtual Kinect, under the contract of all cameras.
#include <map>

#include "hal/camera_contract.hpp"
#include "virtual_kinect.hpp"

namespace onemap::hal {
namespace {

const test::Film& film_of(const std::string& room) {
  static std::map<std::string, test::Film> films;
  const auto found = films.find(room);
  return found != films.end() ? found->second
                              : films.emplace(room, test::Film::shoot(room, test::KinectDevice::develop)).first->second;
}

class KinectRig {
 public:
  static constexpr bool kLive = true;
  KinectRig() {
    one_.plug();
    other_.plug();
  }
  std::string missing() const { return ""; }  // the main program sees whether umockdev is there
  Result<std::unique_ptr<DepthCamera>> open(const std::string& text, Duration clock_offset = {}) {
    auto camera = open_text(open_libusb, text, clock_offset);
    if (!camera) return camera;
    test::VirtualKinect& device = text == other() ? other_ : one_;
    return std::unique_ptr<DepthCamera>(std::make_unique<test::OnDemand>(std::move(*camera), device));
  }
  std::string address() const { return "libusb:KINECT01"; }
  std::string other() const { return "libusb:KINECT02"; }
  std::vector<std::pair<std::string, std::string>> wrong_addresses() const {
    return {{"libusb:KINECT03", "no Kinect with this serial number"},
            {"libusb:?tilt=3", "unknown option 'tilt'"},
            {"libusb:?registration=yes", "expected device, ours or none"}};
  }
  std::vector<std::pair<std::string, std::string>> formats() const {
    return {{address(), "registered by the device"},
            {address() + "?registration=ours", "registered by us"},
            {address() + "?registration=none", "taken as registered"}};
  }
  void plug() {
    resume();
    one_.plug();
  }
  void unplug() { one_.unplug(); }
  void pause() { one_.pause(true); }
  void resume() { one_.pause(false); }

 private:
  test::MockBus bus_;
  test::VirtualKinect one_{bus_, 1, film_of("simulated:office?seed=4&frames=3"), "KINECT01"};
  test::VirtualKinect other_{bus_, 2, film_of("simulated:office?seed=4&robot=2&frames=3"), "KINECT02"};
};
INSTANTIATE_TYPED_TEST_SUITE_P(Kinect, CameraContract, KinectRig);

// A reset of USB that nobody is told of: the device is there, and its streams are silent.
TEST(KinectStalls, AStreamThatGivesNothingIsOpenedAnew) {
  using namespace std::chrono_literals;
  KinectRig rig;
  auto camera = rig.open(rig.address());
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  FramePool pool((*camera)->intrinsics(), 1);
  Frame frame = pool.acquire();
  Grab grab = (*camera)->grab(frame, 20s);
  ASSERT_EQ(grab, Grab::frame) << (*camera)->last_error().text();
  const FrameTime before = frame.colour_time;
  rig.pause();
  grab = (*camera)->grab(frame, 100ms);
  while (grab == Grab::frame) grab = (*camera)->grab(frame, 100ms);
  for (int i = 0; i < 60 && grab == Grab::timeout; ++i) grab = (*camera)->grab(frame, 100ms);
  ASSERT_EQ(grab, Grab::gone);
  EXPECT_THAT((*camera)->last_error().text(),
              testing::HasSubstr("KINECT01: gave nothing for 5 s though it is still connected; it is opened again"));
  rig.resume();
  for (int i = 0; i < 200 && grab != Grab::frame; ++i) grab = (*camera)->grab(frame, 100ms);
  ASSERT_EQ(grab, Grab::frame) << (*camera)->last_error().text();
  EXPECT_GT(frame.colour_time, before);
}

}  // namespace
}  // namespace onemap::hal
