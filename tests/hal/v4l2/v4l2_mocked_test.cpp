// What is V4L2's own in the v4l2 backend, on cameras that umockdev plays. Run it under umockdev-wrapper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>

#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using test::colour_node;
using test::depth_node;
using test::kGrey;
using test::kUyvy;
using test::MockNodeConfig;
using test::MockUvc;
using testing::HasSubstr;

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
  test::Machine machine_;
  int number_ = -2;

  // A camera that has given its first frame.
  struct Streaming {
    MockUvc* mock;
    std::unique_ptr<DepthCamera> camera;
    std::unique_ptr<FramePool> pool;
    Frame frame;
  };
  Streaming stream() {
    Streaming out{&machine_.add(1, 0, depth_node(), colour_node()), open(address()), {}, {}};
    if (!out.camera) return out;
    out.pool = std::make_unique<FramePool>(out.camera->intrinsics(), 1);
    out.frame = out.pool->acquire();
    EXPECT_EQ(out.camera->grab(out.frame, 10s), Grab::frame);
    return out;
  }
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
  colour.content = test::jpeg_images;
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
  Streaming s = stream();
  ASSERT_TRUE(s.camera);
  s.mock->damage_next();
  ASSERT_EQ(s.camera->grab(s.frame, 10s), Grab::bad);
  EXPECT_THAT(s.camera->last_error().text(), HasSubstr("/dev/video1: the driver marks the image as damaged"));
  EXPECT_EQ(s.camera->grab(s.frame, 10s), Grab::frame);
  EXPECT_EQ(s.camera->counters().bad, 1u);
}

TEST_F(V4l2, FramesThatNobodyFetchedAreCounted) {
  Streaming s = stream();
  ASSERT_TRUE(s.camera);
  s.mock->pass(2'000'000);
  for (int i = 0; i < 30; ++i) ASSERT_NE(s.camera->grab(s.frame, 10s), Grab::gone);
  EXPECT_GT(s.camera->counters().missed, 40u);
  EXPECT_LT(s.camera->counters().missed, 62u);
}

TEST_F(V4l2, AnErrorOfTheStreamReopensIt) {
  Streaming s = stream();
  ASSERT_TRUE(s.camera);
  s.mock->refuse(VIDIOC_DQBUF, EIO);
  ASSERT_EQ(s.camera->grab(s.frame, 10s), Grab::gone);
  EXPECT_THAT(s.camera->last_error().text(), HasSubstr("the stream broke: Input/output error"));
  EXPECT_EQ(s.camera->grab(s.frame, 10s), Grab::frame) << s.camera->last_error().text();
}

// A device that is there, and silent: nobody says that anything is wrong.
TEST_F(V4l2, AStreamThatGivesNothingIsOpenedAnew) {
  Streaming s = stream();
  ASSERT_TRUE(s.camera);
  const FrameTime before = s.frame.colour_time;
  s.mock->hang();
  for (int i = 0; i < 49; ++i) ASSERT_EQ(s.camera->grab(s.frame, 100ms), Grab::timeout) << i;
  ASSERT_EQ(s.camera->grab(s.frame, 100ms), Grab::gone);
  EXPECT_THAT(s.camera->last_error().text(),
              HasSubstr("/dev/video0: gave nothing for 5 s though it is still connected; it is opened again"));
  EXPECT_FALSE(s.mock->streaming());
  ASSERT_EQ(s.camera->grab(s.frame, 10s), Grab::frame) << s.camera->last_error().text();
  EXPECT_GT(s.frame.colour_time, before);
}

// Waits that end with a frame do not add up.
TEST_F(V4l2, ASlowStreamIsNotOpenedAnew) {
  MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  const auto camera = open(address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int round = 0; round < 2; ++round) {
    mock.pause(true);
    Grab grab = camera->grab(frame, 20ms);
    while (grab == Grab::frame) grab = camera->grab(frame, 20ms);
    for (int i = 0; i < 18; ++i) ASSERT_EQ(camera->grab(frame, 150ms), Grab::timeout) << round;
    mock.pause(false);
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame);
  }
}

TEST_F(V4l2, ABusWithoutRoomSaysSo) {
  MockUvc& camera = machine_.add(1, 0, depth_node(), colour_node());
  camera.refuse(VIDIOC_STREAMON, ENOSPC);
  EXPECT_THAT(open_error(address()), HasSubstr("the USB bus has no room: another port"));
}

TEST_F(V4l2, Y16IsDepthWhereTheNodeIsNamed) {
  MockNodeConfig depth = depth_node();
  depth.formats = {V4L2_PIX_FMT_Y16};
  machine_.add(1, 0, depth, colour_node());
  EXPECT_THAT(open_error(address()), HasSubstr("no depth camera among the 2 video nodes"));
  const auto camera = open("v4l2:/dev/video0?calibration=" + machine_.file("registered.txt"));
  ASSERT_TRUE(camera);
  EXPECT_THAT(camera->description(), HasSubstr("depth /dev/video0 Y16 640x480"));
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame) << camera->last_error().text();
    const auto depth_is = frame.view().depth;
    EXPECT_EQ(depth_is[640 * 3 + 5], depth_is[0] + 5 + 6);
    EXPECT_NEAR(depth_is[0], 1000, 5);
  }
}

TEST_F(V4l2, ColourMayBeAnotherDevicesWhenItIsNamed) {
  machine_.add(1, 0, depth_node(), colour_node({V4L2_PIX_FMT_SRGGB10}));
  machine_.add(2, 2, colour_node({kGrey}), colour_node());
  EXPECT_THAT(open_error("v4l2:/dev/video0?calibration=" + machine_.file("registered.txt")),
              HasSubstr("no colour node on the same device; name it: ?color=/dev/videoM"));
  const auto camera = open(address("registered.txt", "&color=/dev/video3"));
  ASSERT_TRUE(camera);
  EXPECT_THAT(camera->description(), HasSubstr("depth /dev/video0 Z16 640x480, colour /dev/video3 YUYV 640x480"));
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(camera->grab(frame, 10s), Grab::frame) << camera->last_error().text();
    EXPECT_LE(std::chrono::abs(frame.depth_time - frame.colour_time), Duration(18ms));
  }
  EXPECT_TRUE(machine_.camera(1).streaming_colour());
  machine_.camera(1).unplug();
  Grab grab = Grab::frame;
  for (int i = 0; i < 20 && grab != Grab::gone; ++i) grab = camera->grab(frame, 20ms);
  EXPECT_EQ(grab, Grab::gone);
  machine_.camera(1).plug(4);
  machine_.camera(0).pass(1'000'000);  // as long as that took, for both
  for (int i = 0; i < 20 && grab != Grab::frame; ++i) grab = camera->grab(frame, 20ms);
  EXPECT_EQ(grab, Grab::frame) << camera->last_error().text();
  EXPECT_THAT(camera->description(), HasSubstr("colour /dev/video5"));
}

// Stamps of a clock that nobody names cannot be compared with anything.
TEST_F(V4l2, ImagesWhoseClockIsNotKnownAreBad) {
  for (const auto& [clock, good] : {std::pair(V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN, false),
                                    {V4L2_BUF_FLAG_TIMESTAMP_COPY, true},
                                    {V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, true}}) {
    for (const bool of_colour : {true, false}) {
      MockNodeConfig depth = depth_node(), colour = colour_node();
      (of_colour ? colour : depth).clock = static_cast<std::uint32_t>(clock);
      const int number = number_ += 2;
      MockUvc& mock = machine_.add(1, number, depth, colour);
      const auto camera = open(address());
      ASSERT_TRUE(camera);
      FramePool pool(camera->intrinsics(), 1);
      Frame frame = pool.acquire();
      EXPECT_EQ(camera->grab(frame, 10s), good ? Grab::frame : Grab::bad);
      if (!good) {
        EXPECT_THAT(camera->last_error().text(), HasSubstr("does not say which clock its stamps are of"));
        EXPECT_THAT(camera->last_error().place, HasSubstr(of_colour ? mock.colour_path() : mock.depth_path()));
      }
      mock.unplug();
    }
  }
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
