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
  Result<std::unique_ptr<DepthCamera>> open(const std::string& text) {
    auto camera = open_text(open_libusb, text);
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

}  // namespace
}  // namespace onemap::hal
