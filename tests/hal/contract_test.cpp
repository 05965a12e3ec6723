// The cameras that need no device, under the contract of all cameras.
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/camera_contract.hpp"
#include "hal/encoded_images.hpp"
#include "support/temp_folder.hpp"

namespace onemap::hal {
namespace {

using Wrong = std::vector<std::pair<std::string, std::string>>;
using Formats = std::vector<std::pair<std::string, std::string>>;

struct SimulatedRig {
  static constexpr bool kLive = false;
  static constexpr std::size_t kFrames = 24;
  std::string missing() const { return ""; }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_simulated, address, clock_offset);
  }
  std::string address() const { return "simulated:office?width=96&height=72&frames=24"; }
  std::string other() const { return "simulated:office?width=80&height=60&frames=24&robot=2"; }
  Wrong wrong_addresses() const {
    return {{"simulated:attic", "no scene 'attic'"}, {"simulated:office?speed=2", "unknown option 'speed'"}};
  }
  Formats formats() const {
    return {{address(), "96x72"},
            {"simulated:office?width=320&height=240&frames=2", "320x240"},
            {"simulated:office?width=848&height=480&frames=2&noise=none", "848x480"}};
  }
};
INSTANTIATE_TYPED_TEST_SUITE_P(Simulated, CameraContract, SimulatedRig);

class ReplayRig {
 public:
  static constexpr bool kLive = false;
  static constexpr std::size_t kFrames = 24;
  ReplayRig() {
    write("one", 0, kPng);
    write("other", 100, kPng);
    write("jpeg", 0, kJpeg);
  }
  std::string missing() const { return ""; }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_replay, address, clock_offset);
  }
  std::string address() const { return "replay:" + (folder_ / "one"); }
  std::string other() const { return "replay:" + (folder_ / "other"); }
  Wrong wrong_addresses() const {
    return {{"replay:/nowhere", "no folder"}, {address() + ":30:40", "0 to 24"}, {address() + "?x=1", "option 'x'"}};
  }
  Formats formats() const { return {{address(), "TUM layout"}, {"replay:" + (folder_ / "jpeg"), "TUM layout"}}; }

 private:
  enum Colour { kPng, kJpeg };
  void write(const std::string& name, int seed, Colour colour) const {
    std::string rgb, depth;
    for (int i = 0; i < static_cast<int>(kFrames); ++i) {
      const std::string n = std::to_string(i);
      const auto picture = test::picture(32, 24, seed + i);
      folder_.write(name + "/c" + n,
                    colour == kPng ? test::encode_png(32, 24, {}, picture) : test::encode_jpeg(32, 24, 3, picture));
      folder_.write(name + "/d" + n, test::encode_depth_png(32, 24, test::ramp(32, 24, seed + i)));
      rgb += n + ".100 c" + n + "\n";
      depth += n + ".110 d" + n + "\n";
    }
    folder_.write(name + "/rgb.txt", rgb);
    folder_.write(name + "/depth.txt", depth);
    folder_.write(name + "/calibration.txt", "fx 30\nfy 30\ncx 15.5\ncy 11.5\n");
  }
  test::TempFolder folder_;
};
INSTANTIATE_TYPED_TEST_SUITE_P(Replay, CameraContract, ReplayRig);

}  // namespace
}  // namespace onemap::hal
