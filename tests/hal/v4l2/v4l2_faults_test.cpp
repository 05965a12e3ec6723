// A V4L2 camera that is pulled out at the wrong moment, or has a body that says nonsense of itself. Run it under
// umockdev-wrapper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using test::colour_node;
using test::depth_node;
using test::MockUvc;
using testing::HasSubstr;

class V4l2Faults : public testing::Test {
 protected:
  void SetUp() override {
    if (!machine_.missing().empty()) GTEST_SKIP() << machine_.missing();
  }
  auto open(const char* calibration = "registered.txt") const {
    return open_text(open_v4l2, "v4l2:?calibration=" + machine_.file(calibration));
  }
  std::string open_error(const char* calibration = "registered.txt") const {
    const auto camera = open(calibration);
    return camera ? "" : camera.error().text();
  }
  void plug_again(MockUvc& mock) {
    mock.unplug();
    mock.plug(number_ += 2);
  }
  test::Machine machine_;
  int number_ = 0;
};

TEST_F(V4l2Faults, PulledOutWhileItIsOpenedItIsAnErrorAtEveryStep) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  int steps = 0;
  for (bool opened = false; !opened && steps < 400; ++steps) {
    mock.vanish_at(steps);
    auto camera = open();
    opened = camera.ok();
    EXPECT_TRUE(opened || !camera.error().reason.empty()) << steps;
    if (opened) camera->reset();
    plug_again(mock);
  }
  EXPECT_GT(steps, 30) << "opening it takes more calls than that";
  EXPECT_LT(steps, 400) << "it can be opened";
}

TEST_F(V4l2Faults, PulledOutWhileItIsOpenedAgainItComesBackAllTheSame) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  auto camera = open();
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  FramePool pool((*camera)->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ((*camera)->grab(frame, 10s), Grab::frame);
  mock.unplug();
  ASSERT_EQ((*camera)->grab(frame, 10s), Grab::gone);
  for (int step = 0; step < 35; ++step) {
    mock.plug(number_ += 2);
    mock.vanish_at(step);
    for (int i = 0; i < 2; ++i) ASSERT_EQ((*camera)->grab(frame, 1ms), Grab::gone) << step;
    EXPECT_THAT((*camera)->last_error().place, testing::AnyOf(mock.depth_path(), mock.colour_path())) << step;
    mock.unplug();
  }
  mock.plug(number_ += 2);
  Grab grab = Grab::gone;
  for (int i = 0; i < 100 && grab != Grab::frame; ++i) grab = (*camera)->grab(frame, 100ms);
  EXPECT_EQ(grab, Grab::frame) << (*camera)->last_error().text();
}

TEST_F(V4l2Faults, DepthWithoutColourSaysWhatIsLacking) {
  machine_.add(1, 0, depth_node(), colour_node({V4L2_PIX_FMT_Y10}));
  EXPECT_THAT(open_error(), HasSubstr("/dev/video0: no colour node on the same device; name it: ?color=/dev/videoM"));
  const auto cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_THAT(cameras[0].problem, HasSubstr("no colour node"));
  machine_.add(2, 2, depth_node(), colour_node());
  const auto camera = open();
  ASSERT_TRUE(camera.ok()) << "the first that has both: " << camera.error().text();
  EXPECT_THAT((*camera)->description(), HasSubstr("depth /dev/video2"));
}

// All of these would have gone into registration as they are.
TEST_F(V4l2Faults, ACalibrationOfNoCameraIsRefusedBeforeAnythingStreams) {
  const MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  const std::string good = std::string(test::kRegistered) + test::kDepthLens;
  for (const auto& [key, value] : {std::pair("depth_fx", "1e-30"),
                                   {"fy", "1e30"},
                                   {"depth_cy", "-4e9"},
                                   {"depth_scale", "1e-30"},
                                   {"depth_scale", "nan"},
                                   {"depth_scale", "0"}}) {
    std::string text = "\n" + good;
    const std::size_t at = text.find(std::string("\n") + key + " ") + 1;
    ASSERT_NE(at, 0u) << key;
    text.replace(at, text.find('\n', at) - at, std::string(key) + " " + value);
    machine_.write("wrong.txt", text);
    EXPECT_THAT(open_error("wrong.txt"), testing::AllOf(HasSubstr("wrong.txt:"), HasSubstr(key))) << value;
    EXPECT_FALSE(mock.streaming());
  }
}

}  // namespace
}  // namespace onemap::hal
