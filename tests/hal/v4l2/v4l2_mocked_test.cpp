// The v4l2 backend on cameras that umockdev plays: the contract of all cameras, and what is V4L2's own. Run it under
// umockdev-wrapper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/imaging/encode_image.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using test::colour_node;
using test::depth_node;
using test::kGrey;
using test::kUyvy;
using test::kYuyv;
using test::Machine;
using test::MockNodeConfig;
using test::MockUvc;
using testing::HasSubstr;

class V4l2Rig {
 public:
  static constexpr bool kLive = true;
  V4l2Rig() {
    if (!machine_.missing().empty()) return;
    machine_.add(1, 0, depth_node(), colour_node());
    machine_.add(2, 2, depth_node(500), colour_node());
  }
  std::string missing() const { return machine_.missing(); }
  auto open(const std::string& address) const { return open_text(open_v4l2, address, 1'000'000s); }
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
  void unplug() { machine_.camera(0).unplug(); }
  void plug() { machine_.camera(0).plug(number_ += 2); }  // under other numbers, as the kernel does
  void pause() { machine_.camera(0).pause(true); }
  void resume() { machine_.camera(0).pause(false); }

 private:
  Machine machine_;
  int number_ = 4;
};
INSTANTIATE_TYPED_TEST_SUITE_P(V4l2, CameraContract, V4l2Rig);

class V4l2 : public testing::Test {
 protected:
  void SetUp() override {
    if (!machine_.missing().empty()) GTEST_SKIP() << machine_.missing();
  }
  std::string address(const char* calibration = "registered.txt", const std::string& more = "") const {
    return "v4l2:?calibration=" + machine_.file(calibration) + more;
  }
  std::unique_ptr<DepthCamera> open(const std::string& text) {
    auto camera = open_text(open_v4l2, text);
    if (!camera) {
      ADD_FAILURE() << camera.error().text();
      return nullptr;
    }
    return std::move(*camera);
  }
  std::string open_error(const std::string& text) const {
    const auto camera = open_text(open_v4l2, text);
    return camera ? "" : camera.error().text();
  }
  Machine machine_;
};

TEST_F(V4l2, DepthStaysInTheDriversMemoryWhenTheDeviceRegistersIt) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 2);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  const FrameView view = frame.view();
  EXPECT_NE(view.depth.data(), frame.depth().data()) << "no copy";
  const std::uint16_t first = view.depth[0];
  EXPECT_EQ(view.depth[640 * 3 + 5], first + 5 + 6);
  EXPECT_EQ(view.rgb[3], view.rgb[4]) << "grey";
  EXPECT_EQ(frame.depth_time + 9ms, frame.colour_time);
}

TEST_F(V4l2, AReaderThatKeepsFramesGetsCopiesBeforeTheDriverRunsDry) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 12);
  std::vector<Frame> kept;
  for (int i = 0; i < 12; ++i) {
    kept.push_back(pool.acquire());
    ASSERT_EQ(camera->grab(kept.back(), 10s), Grab::frame) << camera->last_error().text();
  }
  int copies = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    copies += kept[i].view().depth.data() == kept[i].depth().data();
    EXPECT_EQ(kept[i].view().depth[0], kept[0].view().depth[0] + i) << "each its own image";
  }
  EXPECT_GT(copies, 0);
  EXPECT_LT(copies, 12);
  EXPECT_EQ(camera->counters().missed, 0u);
}

TEST_F(V4l2, DepthIsRegisteredWhenItHasALensOfItsOwn) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address("two-lenses.txt"));
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  const std::uint16_t* row = &frame.view().depth[240 * 640];
  const std::uint16_t* source_is = frame.depth().data();
  EXPECT_EQ(frame.view().depth.data(), source_is);
  EXPECT_EQ(row[0], 0) << "2 cm to the right: the colour image's left side has no depth";
  const double z_m = row[320] / 1000.0, shift_px = 600 * 0.02 / z_m;
  EXPECT_NEAR(row[320], 1000 + 320 - shift_px + 2 * 240, 4);
}

TEST_F(V4l2, DepthIsAsItsOwnLensSeesItWhenThatIsWanted) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address("two-lenses.txt", "&registration=none"));
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  const FrameView view = frame.view();
  EXPECT_NE(view.depth.data(), frame.depth().data()) << "no copy";
  EXPECT_EQ(view.depth[240 * 640 + 320], view.depth[240 * 640] + 320);
}

TEST_F(V4l2, PaddedRowsAndOtherFormatsAndSizes) {
  MockNodeConfig depth = depth_node(), colour = colour_node({kUyvy});
  depth.padding_bytes = 64;
  colour.padding_bytes = 32;
  machine_.add(1, 0, depth, colour);
  for (const char* calibration : {"registered.txt", "two-lenses.txt"}) {
    const auto camera = open(address(
        calibration, std::string("&size=320x240") + (calibration[0] == 'r' ? "" : "&depth_size=320x240") + "&fps=15"));
    ASSERT_TRUE(camera);
    EXPECT_EQ(camera->intrinsics().width, 320);
    EXPECT_EQ(camera->intrinsics().fx, 300);
    FramePool pool(camera->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame) << camera->last_error().text();
    const FrameTime first = frame.colour_time;
    EXPECT_GT(frame.view().depth[120 * 320 + 160], 1000);
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
    EXPECT_NEAR(to_seconds(frame.colour_time - first), 1.0 / 15, 0.001);
    EXPECT_THAT(camera->description(), testing::AllOf(HasSubstr("UYVY 320x240"), HasSubstr("15 frames a second")));
  }
}

// Each image is a JPEG with what the buffer held before behind it, as UVC cameras leave it.
TEST_F(V4l2, MjpegBecomesColour) {
  MockNodeConfig colour = colour_node({V4L2_PIX_FMT_MJPEG});
  colour.content = [](const test::MockMode& mode, std::uint32_t sequence, std::uint8_t* out, std::uint32_t) {
    const imaging::ImageSize size{static_cast<int>(mode.width), static_cast<int>(mode.height)};
    std::vector<std::uint8_t> rgb(3 * size.pixels()), file;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
      rgb[i] = 200, rgb[i + 1] = 100, rgb[i + 2] = static_cast<std::uint8_t>(sequence);
    ASSERT_TRUE(imaging::encode_jpeg(size, rgb, 95, file));
    std::ranges::copy(file, out);
  };
  machine_.add(1, 0, depth_node(), colour);
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  EXPECT_THAT(camera->description(), HasSubstr("MJPG 640x480"));
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame) << camera->last_error().text();
    for (const std::size_t pixel : {0u, 640u * 240u + 320u, 640u * 480u - 1u}) {
      EXPECT_NEAR(frame.rgb()[3 * pixel], 200, 4);
      EXPECT_NEAR(frame.rgb()[3 * pixel + 1], 100, 4);
    }
  }
}

TEST_F(V4l2, WhatADriverPutsInPlaceOfWhatItCannotDoIsRefused) {
  MockNodeConfig colour = colour_node();
  colour.sizes = {{320, 240}};
  machine_.add(1, 0, depth_node(), colour);
  EXPECT_THAT(open_error(address()), testing::AllOf(HasSubstr("asked for YUYV 640x480, the driver gives YUYV 320x240"),
                                                    HasSubstr("/dev/video1")));
  machine_.camera(0).unplug();
  MockNodeConfig slow = depth_node();
  slow.fixed_rate = true;
  slow.fps = 5;
  machine_.add(2, 2, slow, colour_node());
  EXPECT_THAT(open_error(address()), HasSubstr("asked for 30 frames a second, the driver gives 5.0"));
  EXPECT_EQ(open_error(address("registered.txt", "&fps=5")), "");
}

TEST_F(V4l2, ADriverWithFewBuffersIsRefusedWithTheirNumber) {
  MockNodeConfig depth = depth_node();
  depth.most_buffers = 2;
  machine_.add(1, 0, depth, colour_node());
  EXPECT_THAT(open_error(address()), HasSubstr("/dev/video0: the driver gives 2 buffers"));
}

TEST_F(V4l2, ABusyCameraSaysSo) {
  MockUvc& camera = machine_.add(1, 0, depth_node(), colour_node());
  camera.refuse(VIDIOC_S_FMT, EBUSY);
  EXPECT_THAT(open_error(address()), HasSubstr("another program uses it"));
}

TEST_F(V4l2, DamagedImagesAreBadAndTheNextIsGood) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  mock.damage_next();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::bad);
  EXPECT_THAT(camera->last_error().text(), HasSubstr("/dev/video1: the driver marks the image as damaged"));
  EXPECT_EQ(camera->grab(frame, 10s), Grab::frame);
  EXPECT_EQ(camera->counters().bad, 1u);
}

TEST_F(V4l2, FramesThatNobodyFetchedAreCounted) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  mock.pass(2'000'000);
  for (int i = 0; i < 30; ++i) ASSERT_NE(camera->grab(frame, 10s), Grab::gone);
  EXPECT_GT(camera->counters().missed, 40u);
  EXPECT_LT(camera->counters().missed, 62u);
}

TEST_F(V4l2, AnErrorOfTheStreamReopensIt) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  mock.refuse(VIDIOC_DQBUF, EIO);
  ASSERT_EQ(camera->grab(frame, 10s), Grab::gone);
  EXPECT_THAT(camera->last_error().text(), HasSubstr("the stream broke: Input/output error"));
  EXPECT_EQ(camera->grab(frame, 10s), Grab::frame) << camera->last_error().text();
}

TEST_F(V4l2, AnotherCameraAtTheSamePortIsNotTheOneThatLeft) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  machine_.camera(0).unplug();
  machine_.add(1, 2, depth_node(), colour_node(), "8086:0ad3");
  Grab grab = Grab::frame;
  for (int i = 0; i < 20; ++i) grab = camera->grab(frame, 20ms);
  EXPECT_EQ(grab, Grab::gone);
  EXPECT_THAT(camera->last_error().text(), HasSubstr("another device, 8086:0ad3 S1, is plugged in"));
}

TEST_F(V4l2, ColourIsFoundOnTheSameDeviceAndGreyIsTheLastChoice) {
  machine_.add(1, 0, depth_node(), colour_node({kGrey}));
  machine_.add(2, 2, colour_node({kGrey}), colour_node());  // a webcam, not of this device
  EXPECT_THAT(list_v4l2(), testing::ElementsAre(testing::Field(&CameraInfo::address, "v4l2:/dev/video0")));
  EXPECT_THAT(list_v4l2()[0].abilities, HasSubstr("colour /dev/video1 GREY 640x480 320x240"));
}

TEST_F(V4l2, ListSaysWhatIsThereAndWhyOneCannotBeUsed) {
  machine_.add(1, 0, depth_node(), colour_node(), "1234:5678");
  machine_.add(2, 2, depth_node(), colour_node());
  machine_.add(3, 4, depth_node(), depth_node());
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 4u);
  EXPECT_EQ(cameras[0].address, "v4l2:/dev/video2");
  EXPECT_EQ(cameras[0].description, "Mock depth camera S2 (USB 8086:0b07)");
  EXPECT_EQ(cameras[0].problem, "");
  EXPECT_THAT(cameras[0].abilities,
              testing::AllOf(HasSubstr("depth /dev/video2 Z16 640x480 320x240; colour /dev/video3 YUYV"),
                             HasSubstr("USB 2 port"), HasSubstr("nominal for realsense-d435")));
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video0");
  EXPECT_THAT(cameras[1].problem, HasSubstr("no calibration is known for USB device 1234:5678"));
  EXPECT_THAT(cameras[2].problem, HasSubstr("no colour node on the same device"));
}

TEST_F(V4l2, TheFirstUsableIsOpenedWithTheModelsCalibration) {
  machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open("v4l2:");
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->intrinsics().fx, 615);
  EXPECT_NEAR(camera->depth_noise().growth_per_m, 0.0042, 1e-9);
  EXPECT_THAT(camera->description(),
              testing::AllOf(HasSubstr("Mock depth camera S1"), HasSubstr("nominal for realsense-d435")));
}

TEST_F(V4l2, WithoutACameraTheErrorNamesWhatIsThere) {
  EXPECT_THAT(open_error("v4l2:"), HasSubstr("no depth camera among the 0 video nodes"));
  machine_.add(1, 0, colour_node(), colour_node());
  EXPECT_THAT(open_error("v4l2:"), testing::AllOf(HasSubstr("among the 2 video nodes"),
                                                  HasSubstr("/dev/video0 (Mock depth camera): no depth format")));
}

}  // namespace
}  // namespace onemap::hal
