// The v4l2 backend, on cameras that umockdev plays, under the contract of all cameras.
#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using test::colour_node;
using test::depth_node;

class V4l2Rig {
 public:
  static constexpr bool kLive = true;
  V4l2Rig() {
    if (!machine_.missing().empty()) return;
    machine_.add(1, 0, depth_node(), colour_node());
    machine_.add(2, 2, depth_node(500), colour_node());
  }
  std::string missing() const { return machine_.missing(); }
  auto open(const std::string& address, Duration clock_offset = {}) const {
    return open_text(open_v4l2, address, clock_offset);
  }
  std::string address() const { return "v4l2:/dev/video0?calibration=" + machine_.file("registered.txt"); }
  std::string other() const { return "v4l2:/dev/video2?calibration=" + machine_.file("registered.txt"); }
  std::vector<std::pair<std::string, std::string>> wrong_addresses() const {
    return {{"v4l2:/dev/video9", "/dev/video9: cannot be opened: No such file"},
            {"v4l2:video0", "expected v4l2: or v4l2:/dev/videoN"},
            {"v4l2:?speed=1", "unknown option 'speed'"},
            {"v4l2:?size=640", "expected WIDTHxHEIGHT"},
            {"v4l2:?fps=0", "from 1 to 120"},
            {"v4l2:/dev/video1", "no depth format (Z16, Y16); it has YUYV"},
            {"v4l2:?calibration=/nowhere.txt", "/nowhere.txt: cannot read"},
            {address() + "&color=/dev/video2", "no colour format (YUYV, UYVY, MJPG, GREY); it has Z16"}};
  }
  std::vector<std::pair<std::string, std::string>> formats() {
    std::vector<std::pair<std::string, std::string>> out{{address(), "Z16 640x480, colour /dev/video1 YUYV 640x480"}};
    const auto add = [&](std::uint32_t depth_format, std::uint32_t colour_format, const std::string& says) {
      test::MockNodeConfig depth = depth_node(), colour = colour_node({colour_format});
      depth.formats = {depth_format};
      if (colour_format == V4L2_PIX_FMT_MJPEG) colour.content = test::jpeg_images;
      const int number = 20 + 2 * static_cast<int>(out.size());
      machine_.add(number, number, depth, colour);
      out.emplace_back("v4l2:/dev/video" + std::to_string(number) + "?calibration=" + machine_.file("registered.txt"),
                       says);
    };
    add(test::kZ16, test::kUyvy, "UYVY");
    add(test::kZ16, V4L2_PIX_FMT_MJPEG, "MJPG");
    add(test::kZ16, test::kGrey, "GREY");
    add(V4L2_PIX_FMT_Y16, test::kYuyv, "Y16 640x480");
    out.emplace_back(address() + "&size=320x240", "Z16 320x240");
    out.emplace_back("v4l2:/dev/video0?calibration=" + machine_.file("two-lenses.txt"), "two-lenses.txt");
    return out;
  }
  void unplug() { machine_.camera(0).unplug(); }
  void plug() { machine_.camera(0).plug(number_ += 2); }  // under other numbers, as the kernel does
  void pause() { machine_.camera(0).pause(true); }
  void resume() { machine_.camera(0).pause(false); }

 private:
  test::Machine machine_;
  int number_ = 4;
};
INSTANTIATE_TYPED_TEST_SUITE_P(V4l2, CameraContract, V4l2Rig);

}  // namespace
}  // namespace onemap::hal
