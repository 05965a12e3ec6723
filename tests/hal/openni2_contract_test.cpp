#ifdef ONEMAP_OPENNI2_DIR  // else openni2_absent_test.cpp
#include <array>
#include <filesystem>

#include "hal/backends/openni2.hpp"
#include "hal/camera_contract.hpp"
#include "support/openni2_devices.hpp"
#include "support/openni2_recording.hpp"

// The OpenNI2 backend, on our driver in the real library, under the contract of all cameras.
namespace onemap::hal {
namespace {

class OpenNi2Rig {
 public:
  static constexpr bool kLive = true;
  OpenNi2Rig() {
    plug();
    devices_.plug("b", "room simulated:office?width=80&height=60\non_demand 1\n");
    devices_.plug("fine", kOffice + "hundred_um 1\n");
  }
  std::string missing() const { return ""; }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_openni2, address, clock_offset);
  }
  std::string address() const { return "openni2:room://a"; }
  std::string other() const { return "openni2:room://b"; }
  std::vector<std::pair<std::string, std::string>> wrong_addresses() const {
    return {{"openni2:room://c", "room://c"},
            {"openni2:/nowhere.oni", "/nowhere.oni"},
            {"openni2:?speed=2", "unknown option 'speed'"},
            {"openni2:?mode=1920x1080@30", "there is no mode 1920x1080@30"}};
  }
  std::vector<std::pair<std::string, std::string>> formats() const {
    return {{address(), "96x72@30 1 mm (registered by the device), colour 96x72@30 RGB"},
            {address() + "?registration=ours", "1 mm (registered by us)"},
            {address() + "?mode=96x72@30&registration=none", "1 mm (taken as registered)"},
            {"openni2:room://fine", "100 um (registered by the device)"}};
  }
  void plug() {
    resume();
    devices_.plug("a", kOffice);
  }
  void unplug() { devices_.unplug("a"); }
  void pause() { devices_.folder().write("a.paused", ""); }
  void resume() { std::filesystem::remove(devices_.folder() / "a.paused"); }

 private:
  const std::string kOffice = "room simulated:office?width=96&height=72\non_demand 1\n";
  test::OpenNi2Devices devices_;
};
INSTANTIATE_TYPED_TEST_SUITE_P(OpenNi2, CameraContract, OpenNi2Rig);

// Two recordings by the library's own recorder, made once; again where it has left an image out.
class OniRig {
 public:
  static constexpr bool kLive = false;
  static constexpr std::size_t kFrames = 24;
  std::string missing() const { return recordings().missing; }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_openni2, address, clock_offset);
  }
  std::string address() const { return "openni2:" + recordings().file("one"); }
  std::string other() const { return "openni2:" + recordings().file("other"); }
  std::vector<std::pair<std::string, std::string>> wrong_addresses() const {
    return {{"openni2:/nowhere.oni", "/nowhere.oni"},
            {address() + "?registration=device", "a recording"},
            {address() + "?mode=1920x1080@30", "there is no mode 1920x1080@30"}};
  }
  std::vector<std::pair<std::string, std::string>> formats() const {
    return {{address(), "96x72@30 1 mm (taken as registered)"},
            {address() + "?registration=ours", "1 mm (registered by us)"},
            {"openni2:" + recordings().file("fine"), "96x72@30 100 um"}};
  }

 private:
  class Recordings {
   public:
    Recordings() {
      make("one", "seed=3");
      make("other", "seed=3&robot=2");
      make("fine", "seed=3", "hundred_um 1\n");
    }
    std::string file(const std::string& name) const { return folder_ / (name + ".oni"); }
    std::string missing;

   private:
    void make(const std::string& name, const std::string& walk, const std::string& more = "") {
      constexpr int kWanted = static_cast<int>(kFrames), kTries = 10;
      for (int i = 0; i < kTries; ++i) {
        {
          test::OpenNi2Devices devices;
          devices.plug(name, "room simulated:office?width=96&height=72&" + walk + "\nsteps 1\n" + more);
          test::record(devices, name, file(name), kWanted);
        }
        if (test::images_in(file(name)) == std::array{kWanted, kWanted}) return;
      }
      missing = "OpenNI2's recorder leaves images out, ten times over: this machine is too busy";
    }
    test::TempFolder folder_;
  };
  static const Recordings& recordings() {
    static const Recordings made;
    return made;
  }
};
INSTANTIATE_TYPED_TEST_SUITE_P(OniFile, CameraContract, OniRig);

}  // namespace
}  // namespace onemap::hal
#endif
