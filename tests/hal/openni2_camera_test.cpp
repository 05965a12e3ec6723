#ifdef ONEMAP_OPENNI2_DIR  // else openni2_absent_test.cpp
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#include "support/openni2_devices.hpp"

// The backend through the real OpenNI2 library: its own driver for recordings, and ours for devices.
namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr auto kPatience = 20s;  // for what comes at once on an idle machine
const std::string kRoom = "simulated:living-room?seed=5&width=320&height=240";
const std::string kSteps = "room " + kRoom + "\nsteps 1\nhundred_um 1\n";

class OpenNi2CameraTest : public testing::Test {
 protected:
  void open(const std::string& text, Duration clock_offset = {}) {
    auto address = parse_camera_address(text);
    ASSERT_TRUE(address.ok());
    address->clock_offset = clock_offset;
    camera_.reset();
    auto camera = open_openni2(*address);
    ASSERT_TRUE(camera.ok()) << camera.error().text();
    camera_ = std::move(*camera);
    frame_ = Frame();
    pool_ = std::make_unique<FramePool>(camera_->intrinsics(), 1);
    frame_ = pool_->acquire();
  }
  static std::string open_error(const std::string& text) {
    const auto address = parse_camera_address(text);
    EXPECT_TRUE(address.ok());
    const auto camera = open_openni2(*address);
    EXPECT_FALSE(camera.ok());
    return camera.ok() ? "" : camera.error().text();
  }
  // Calls grab until it says something else than `pass`.
  Grab grab_past(Grab pass) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    Grab grab = pass;
    while (grab == pass && std::chrono::steady_clock::now() < end) grab = camera_->grab(frame_, 50ms);
    return grab;
  }
  Grab step_and_grab(const std::string& name = "a") {
    devices_.step(name);
    return grab_past(Grab::timeout);
  }

  test::OpenNi2Devices devices_;
  std::unique_ptr<DepthCamera> camera_;
  std::unique_ptr<FramePool> pool_;
  Frame frame_;
};

// The frames that a device's room gives, in its own camera's units.
class Room {
 public:
  explicit Room(const std::string& text) {
    camera_ = std::move(open_simulated(*parse_camera_address(text))).value();
    pool_ = std::make_unique<FramePool>(camera_->intrinsics(), 1);
    frame_ = pool_->acquire();
  }
  const Frame& next() {
    EXPECT_EQ(camera_->grab(frame_, 0ms), Grab::frame);
    return frame_;
  }

 private:
  std::unique_ptr<DepthCamera> camera_;
  std::unique_ptr<FramePool> pool_;
  Frame frame_;
};

TEST_F(OpenNi2CameraTest, PlaysARealRecording) {
  const std::string file = std::string(ONEMAP_SHARED_DIR) + "/data/static_room.oni";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recording at " << file;
  open("openni2:" + file);
  EXPECT_FALSE(camera_->live());
  EXPECT_EQ(camera_->frames_expected(), 12u);
  EXPECT_EQ(camera_->intrinsics(), Intrinsics({.depth_scale = 1000})) << "the recording has no field of view";
  EXPECT_THAT(camera_->description(),
              testing::AllOf(HasSubstr("static_room.oni"), HasSubstr("nominal"), HasSubstr("taken as registered")));
  FrameTime last = frame_time_from_ns(-1);
  for (std::uint64_t i = 0; i < 12; ++i) {
    ASSERT_EQ(grab_past(Grab::timeout), Grab::frame) << i;
    EXPECT_EQ(frame_.index, i);
    EXPECT_GT(frame_.colour_time, last);
    last = frame_.colour_time;
    EXPECT_NEAR(to_seconds(frame_.depth_time - frame_.colour_time), 0.0118, 0.0003);
    const auto seen = std::ranges::count_if(frame_.depth(), [](std::uint16_t z) { return z > 500 && z < 8000; });
    EXPECT_GT(seen, 150'000) << "most of the room is between half a metre and eight";
  }
  EXPECT_EQ(camera_->grab(frame_, 0ms), Grab::end);
  EXPECT_EQ(camera_->grab(frame_, 0ms), Grab::end);
  EXPECT_EQ(camera_->counters().frames, 12u);
  EXPECT_EQ(camera_->counters().unmatched + camera_->counters().missed + camera_->counters().bad, 0u);
  EXPECT_EQ(camera_->frames_expected(), 0u);
}

TEST_F(OpenNi2CameraTest, TheFirstDeviceGivesItsRoomPixelForPixel) {
  devices_.plug("a", kSteps + "depth_late_us 5000\n");
  open("openni2:", 1000s);
  EXPECT_TRUE(camera_->live());
  EXPECT_THAT(camera_->description(), testing::AllOf(HasSubstr("room://a"), HasSubstr("registered by the device"),
                                                     HasSubstr("serial number TEST1"), HasSubstr("320x240@30 100 um")));
  const Intrinsics& k = camera_->intrinsics();
  EXPECT_EQ(k.width, 320);
  EXPECT_NEAR(k.fx, 262.5, 1e-3);  // the field of view is a float
  EXPECT_EQ(k.cx, 159.5);
  EXPECT_EQ(k.depth_scale, 10000);
  Room room(kRoom);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(step_and_grab(), Grab::frame) << camera_->last_error().text();
    const Frame& truth = room.next();
    EXPECT_TRUE(std::ranges::equal(frame_.rgb(), truth.rgb())) << "not mirrored, frame " << i;
    EXPECT_TRUE(std::ranges::equal(frame_.depth(), truth.depth(),
                                   [](std::uint16_t got, std::uint16_t wanted) { return got == 2 * wanted; }));
    EXPECT_EQ(frame_.index, static_cast<std::uint64_t>(i));
    EXPECT_NEAR(to_seconds(frame_.colour_time), 1000.001 + i / 30.0, 2e-6);
    EXPECT_EQ(frame_.depth_time - frame_.colour_time, Duration(5ms));
  }
  EXPECT_EQ(camera_->grab(frame_, 30ms), Grab::timeout) << "no step, no picture";
  EXPECT_EQ(camera_->counters().frames, 5u);
}

TEST_F(OpenNi2CameraTest, MillimetresAreAnotherScale) {
  devices_.plug("a", "room " + kRoom + "\nsteps 1\n");
  open("openni2:room://a");
  EXPECT_EQ(camera_->intrinsics().depth_scale, 1000);
  ASSERT_EQ(step_and_grab(), Grab::frame);
  Room room(kRoom);
  const Frame& truth = room.next();
  for (std::size_t i = 0; i < truth.depth().size(); ++i)
    ASSERT_NEAR(frame_.depth()[i] * 0.001, truth.depth()[i] / 5000.0, 0.00051);
}

TEST_F(OpenNi2CameraTest, WithoutADeviceThatRegistersWeDo) {
  devices_.plug("a", "room simulated:living-room?seed=5&noise=none\nsteps 1\nhundred_um 1\nregisters 0\n");
  EXPECT_THAT(open_error("openni2:?registration=device"), HasSubstr("cannot register"));
  open("openni2:");
  EXPECT_THAT(camera_->description(), HasSubstr("registered by us"));
  Room room("simulated:living-room?seed=5&noise=none");
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(step_and_grab(), Grab::frame);
    const Frame& truth = room.next();
    std::size_t seen = 0, both = 0, same = 0;
    for (std::size_t p = 0; p < truth.depth().size(); ++p) {
      const std::size_t x = p % 640, y = p / 640;
      const bool in_view = x > 50 && x < 590 && y > 30 && y < 450;  // of the depth camera, which sees less
      if (!in_view || truth.depth()[p] == 0) continue;
      ++seen;
      if (frame_.depth()[p] == 0) continue;
      ++both;
      same += std::abs(frame_.depth()[p] / 10000.0 - truth.depth()[p] / 5000.0) < 0.01 * truth.depth()[p] / 5000.0;
    }
    EXPECT_GT(both, 0.96 * seen) << "the rest: beside near things, where the depth camera sees nothing";
    EXPECT_GT(same, 0.97 * both) << "of the rest: edges, by a pixel";
  }
}

TEST_F(OpenNi2CameraTest, ADeviceThatTakesAnotherModeIsRefused) {
  devices_.plug("a", kSteps + "substitutes 1\n");
  EXPECT_THAT(open_error("openni2:"), HasSubstr("took 160x120@30 100 um where 320x240@30 100 um was set"));
}

// As OpenNI2's own drivers where udev's daemon does not run, in many containers.
TEST_F(OpenNi2CameraTest, ADeviceThatItsDriverDoesNotHearComeIsFoundAllTheSame) {
  devices_.plug("a", kSteps + "unheard 1\n");
  EXPECT_EQ(list_openni2().size(), 1u);
  open("openni2:");
  ASSERT_EQ(step_and_grab(), Grab::frame) << camera_->last_error().text();
  const FrameTime before = frame_.colour_time;
  devices_.unplug("a");
  Grab grab = Grab::timeout;
  for (int i = 0; i < 100 && grab != Grab::gone; ++i) grab = camera_->grab(frame_, 50ms);
  ASSERT_EQ(grab, Grab::gone);
  devices_.plug("a", kSteps + "unheard 1\n");
  for (int i = 0; i < 400 && grab == Grab::gone; ++i) grab = camera_->grab(frame_, 50ms);
  ASSERT_EQ(grab, Grab::timeout) << "it is there and has no picture yet: " << camera_->last_error().text();
  ASSERT_EQ(step_and_grab(), Grab::frame) << camera_->last_error().text();
  EXPECT_GT(frame_.colour_time, before);
}

TEST_F(OpenNi2CameraTest, BadAddressesSayWhatIsWrong) {
  EXPECT_THAT(open_error("openni2:"), HasSubstr("no device"));
  EXPECT_THAT(open_error("openni2:room://nobody"), HasSubstr("camera room://nobody: cannot be opened: DeviceOpen: "));
  EXPECT_EQ(open_error("openni2:/nowhere/file.oni"),
            "camera /nowhere/file.oni: cannot be read: No such file or directory");
  devices_.folder().write("bad.oni", "this is no recording");
  EXPECT_THAT(open_error("openni2:" + (devices_.folder() / "bad.oni")), HasSubstr("bad.oni"));
  devices_.plug("a", kSteps);
  EXPECT_THAT(open_error("openni2:?mode=640x480"), HasSubstr("WIDTHxHEIGHT@FPS"));
  EXPECT_THAT(open_error("openni2:?mode=640x480@30"), HasSubstr("colour has 640x480@15 RGB"));
  EXPECT_THAT(open_error("openni2:?speed=2"), HasSubstr("unknown option 'speed'"));
  EXPECT_THAT(open_error("openni2:?registration=yes"), HasSubstr("expected device, ours or none"));
  EXPECT_THAT(open_error("openni2:x.oni?registration=device"), HasSubstr("a recording"));
  EXPECT_THAT(open_error("openni2:?baseline=2"), HasSubstr("metres from -0.5 to 0.5"));
  EXPECT_THAT(open_error("openni2:?calibration=/nowhere.txt"), HasSubstr("/nowhere.txt"));
  EXPECT_THAT(open_error("openni2:?fx=500"), HasSubstr("lacks fy cx cy"));
  EXPECT_THAT(open_error("openni2:?fx=wide"), HasSubstr("not a number"));
}

TEST_F(OpenNi2CameraTest, ACalibrationGoesOverTheFieldOfView) {
  devices_.plug("a", kSteps);
  devices_.folder().write("calibration.txt", "fx 250\nfy 251\ncx 150\ncy 110\nk1 0.1\n");
  const std::string file = devices_.folder() / "calibration.txt";
  open("openni2:?calibration=" + file + "&cy=111");
  const Intrinsics& k = camera_->intrinsics();
  EXPECT_EQ(
      k,
      Intrinsics(
          {.width = 320, .height = 240, .fx = 250, .fy = 251, .cx = 150, .cy = 111, .k1 = 0.1, .depth_scale = 10000}));
  EXPECT_THAT(camera_->description(), HasSubstr(file));
}

TEST_F(OpenNi2CameraTest, ADeviceThatIsPulledOutIsGoneAndComesBack) {
  for (const bool restarts : {true, false}) {
    const std::string lines = kSteps + "clock_restarts " + (restarts ? "1" : "0") + "\n";
    const std::string name = restarts ? "a" : "b";
    devices_.plug(name, lines);
    const std::string address = "openni2:room://" + name;
    // The library may have been loaded before the device was there.
    open(address);
    ASSERT_EQ(step_and_grab(name), Grab::frame);
    ASSERT_EQ(step_and_grab(name), Grab::frame);
    const FrameTime last = frame_.colour_time;
    devices_.unplug(name);
    ASSERT_EQ(grab_past(Grab::timeout), Grab::gone);
    EXPECT_THAT(camera_->last_error().text(), testing::AllOf(HasSubstr(name), HasSubstr("disconnected")));
    EXPECT_EQ(camera_->grab(frame_, 10ms), Grab::gone) << "until it is back";
    devices_.plug(name, lines);
    devices_.step(name);
    Grab grab = grab_past(Grab::gone);
    if (grab == Grab::timeout) grab = grab_past(Grab::timeout);
    ASSERT_EQ(grab, Grab::frame) << camera_->last_error().text();
    EXPECT_GT(frame_.colour_time, last);
    EXPECT_EQ(frame_.index, 2u);
    if (!restarts) {
      EXPECT_NEAR(to_seconds(frame_.colour_time - last), 1 / 30.0, 1e-5);
    }
    EXPECT_EQ(step_and_grab(name), Grab::frame);
    EXPECT_EQ(camera_->counters().frames, 4u);
    camera_.reset();
    devices_.unplug(name);
  }
}

// No callback tells of a reset of USB: the device is there, and its streams are silent.
TEST_F(OpenNi2CameraTest, ADeviceThatGivesNothingIsOpenedAnew) {
  devices_.plug("a", kSteps + "clock_restarts 1\n");
  open("openni2:");
  ASSERT_EQ(step_and_grab(), Grab::frame);
  const FrameTime last = frame_.colour_time;
  for (int i = 0; i < 2; ++i) ASSERT_EQ(camera_->grab(frame_, 1s), Grab::timeout) << i;
  ASSERT_EQ(step_and_grab(), Grab::frame) << "in time";
  for (int i = 0; i < 4; ++i) ASSERT_EQ(camera_->grab(frame_, 1s), Grab::timeout) << i;
  ASSERT_EQ(camera_->grab(frame_, 1s), Grab::gone);
  EXPECT_THAT(camera_->last_error().text(),
              HasSubstr("room://a: gave nothing for 5 s though it is still connected; it is opened again"));
  devices_.step("a");
  Grab grab = grab_past(Grab::gone);
  if (grab == Grab::timeout) grab = grab_past(Grab::timeout);
  ASSERT_EQ(grab, Grab::frame) << camera_->last_error().text();
  EXPECT_GE(frame_.colour_time - last, Duration(5s)) << "its clock began anew, and the silence counts";
  EXPECT_EQ(frame_.index, 2u);
}

TEST_F(OpenNi2CameraTest, AnotherDeviceIsNotTakenForTheOneThatLeft) {
  devices_.plug("a", kSteps + "serial ONE\n");
  open("openni2:");
  ASSERT_EQ(step_and_grab(), Grab::frame);
  devices_.unplug("a");
  ASSERT_EQ(grab_past(Grab::timeout), Grab::gone);
  devices_.plug("b", kSteps + "serial TWO\n");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(camera_->grab(frame_, 20ms), Grab::gone);
  devices_.plug("c", kSteps + "serial ONE\n");  // another socket: another URI
  devices_.step("c");
  Grab grab = grab_past(Grab::gone);
  if (grab == Grab::timeout) grab = grab_past(Grab::timeout);
  EXPECT_EQ(grab, Grab::frame);
  EXPECT_THAT(camera_->description(), HasSubstr("room://c")) << "where it is now";
}

TEST_F(OpenNi2CameraTest, OneThatHasTheSameSerialNumberIsNotTakenForTheOneThatLeft) {
  devices_.plug("a", kSteps + "serial ONE\n");
  devices_.plug("twin", kSteps + "serial ONE\n");
  open("openni2:room://a");
  ASSERT_EQ(step_and_grab(), Grab::frame);
  devices_.unplug("a");
  ASSERT_EQ(grab_past(Grab::timeout), Grab::gone);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(camera_->grab(frame_, 20ms), Grab::gone) << "the twin is there";
  devices_.plug("c", kSteps + "serial ONE\n");
  devices_.step("c");
  Grab grab = grab_past(Grab::gone);
  if (grab == Grab::timeout) grab = grab_past(Grab::timeout);
  EXPECT_EQ(grab, Grab::frame) << camera_->last_error().text();
  EXPECT_THAT(camera_->description(), HasSubstr("room://c"));
}

TEST_F(OpenNi2CameraTest, ClosesAndOpensAgainWhileItStreams) {
  devices_.plug("a", "room " + kRoom + "\nhz 30\n");
  for (int i = 0; i < 3; ++i) {
    open("openni2:");
    EXPECT_EQ(grab_past(Grab::timeout), Grab::frame);
  }
}

TEST_F(OpenNi2CameraTest, WhatNobodyFetchedIsCounted) {
  devices_.plug("a", "room simulated:living-room?width=64&height=48\nhz 200\n");
  open("openni2:");
  ASSERT_EQ(grab_past(Grab::timeout), Grab::frame);
  std::this_thread::sleep_for(200ms);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(grab_past(Grab::timeout), Grab::frame);
  EXPECT_GT(camera_->counters().missed, 0u);
  EXPECT_EQ(camera_->counters().missed, frame_.index + 1 - 4);
}

TEST_F(OpenNi2CameraTest, TwoAtOnce) {
  devices_.plug("a", kSteps);
  devices_.plug("b", "room simulated:office?width=320&height=240\nsteps 1\n");
  open("openni2:room://a");
  auto other = std::move(open_openni2(*parse_camera_address("openni2:room://b"))).value();
  FramePool pool(other->intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(step_and_grab("a"), Grab::frame);
    devices_.step("b");
    Grab grab = Grab::timeout;
    for (int tries = 0; tries < 400 && grab == Grab::timeout; ++tries) grab = other->grab(frame, 50ms);
    ASSERT_EQ(grab, Grab::frame);
    EXPECT_FALSE(std::ranges::equal(frame.rgb(), frame_.rgb()));
  }
  devices_.unplug("b");
  ASSERT_EQ(step_and_grab("a"), Grab::frame) << "the other one's departure is not ours";
  Grab grab = Grab::timeout;
  for (int tries = 0; tries < 400 && grab == Grab::timeout; ++tries) grab = other->grab(frame, 50ms);
  EXPECT_EQ(grab, Grab::gone);
  frame = Frame();
}

TEST_F(OpenNi2CameraTest, AreListedWithTheirAddress) {
  EXPECT_TRUE(list_openni2().empty());
  devices_.plug("a", kSteps);
  const auto cameras = list_openni2();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].address, "openni2:room://a");
  EXPECT_EQ(cameras[0].description, "onemap Simulated room (USB 1d27:0601)");
  EXPECT_EQ(cameras[0].problem, "");
  devices_.plug("b", kSteps + "unheard 1\n");
  EXPECT_EQ(list_openni2().size(), 2u) << "what the drivers do not hear come (no udev) is there when they begin";
  open(cameras[0].address);
}

}  // namespace
}  // namespace onemap::hal
#endif
