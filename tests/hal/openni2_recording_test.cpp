#ifdef ONEMAP_OPENNI2_DIR  // else openni2_absent_test.cpp
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#include "support/openni2_devices.hpp"
#include "support/openni2_recording.hpp"
#include "support/text_of.hpp"

// What OpenNI2's recorder writes from a device of ours, played by OpenNI2's own driver for files.
namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

const std::string kRecordedRoom = "simulated:office?seed=3&width=160&height=120";

struct Picture {
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

std::vector<Picture> room_pictures(int frames) {
  auto room = std::move(open_simulated(*parse_camera_address(kRecordedRoom))).value();
  FramePool pool(room->intrinsics(), 1);
  Frame frame = pool.acquire();
  std::vector<Picture> out;
  for (int i = 0; i < frames; ++i) {
    EXPECT_EQ(room->grab(frame, 0ms), Grab::frame);
    out.push_back({{frame.rgb().begin(), frame.rgb().end()}, {frame.depth().begin(), frame.depth().end()}});
    for (std::uint16_t& value : out.back().depth) value = static_cast<std::uint16_t>(2 * value);  // 100 um
  }
  return out;
}

// When the machine is busy the library's recorder leaves images out, and stamps the first of each stream with its own
// time: which picture of the room an image is, only its pixels tell.
void expect_room(const std::string& file, int frames) {
  auto camera = open_openni2(*parse_camera_address("openni2:" + file));
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  const std::vector<Picture> room = room_pictures(frames);
  EXPECT_NEAR((*camera)->intrinsics().fx, 525 / 4.0, 1e-3) << "the field of view is recorded";
  FramePool pool((*camera)->intrinsics(), 1);
  Frame got = pool.acquire();
  std::vector<std::ptrdiff_t> colours;
  Grab grab = Grab::timeout;
  for (int tries = 0; grab != Grab::end && tries < 400; ++tries) {
    grab = (*camera)->grab(got, 50ms);
    ASSERT_TRUE(grab == Grab::frame || grab == Grab::timeout || grab == Grab::end) << (*camera)->last_error().text();
    if (grab != Grab::frame) continue;
    const auto colour = std::ranges::find_if(room, [&](auto& p) { return std::ranges::equal(p.rgb, got.rgb()); });
    const auto depth = std::ranges::find_if(room, [&](auto& p) { return std::ranges::equal(p.depth, got.depth()); });
    ASSERT_NE(colour, room.end()) << "not a picture of the room, frame " << got.index;
    ASSERT_NE(depth, room.end()) << "not a depth image of the room, frame " << got.index;
    EXPECT_LE(std::abs(colour - depth), 1);
    if (!colours.empty()) {
      EXPECT_GT(colour - room.begin(), colours.back());
    }
    colours.push_back(colour - room.begin());
  }
  EXPECT_EQ(grab, Grab::end);
  EXPECT_GT(colours.size(), static_cast<std::size_t>(frames) / 3);
}

TEST(OpenNi2Recording, IsPlayedPixelForPixel) {
  test::OpenNi2Devices devices;
  devices.plug("a", "room " + kRecordedRoom + "\nsteps 1\nhundred_um 1\n");
  const std::string file = devices.folder() / "room.oni";
  test::record(devices, "a", file, 12);
  if (HasFatalFailure()) return;
  devices.unplug("a");
  expect_room(file, 12);
}

// Its thread is cancelled by the library when a file is closed, and may still run in its code when that is unloaded.
TEST(OpenNi2Recording, LeavesThePlayersCodeInMemory) {
  test::OpenNi2Devices devices;
  devices.plug("a", "room " + kRecordedRoom + "\nsteps 1\n");
  const std::string file = devices.folder() / "room.oni";
  test::record(devices, "a", file, 4);
  if (HasFatalFailure()) return;
  ASSERT_TRUE(open_openni2(*parse_camera_address("openni2:" + file)).ok());  // and closed again
  EXPECT_THAT(test::text_of("/proc/self/maps"), testing::HasSubstr("libOniFile.so"));
}

TEST(OpenNi2Recording, ThatBreaksOffSaysSoAndEnds) {
  test::OpenNi2Devices devices;
  devices.plug("a", "room " + kRecordedRoom + "\nsteps 1\n");
  const std::string file = devices.folder() / "room.oni";
  test::record(devices, "a", file, 8);
  if (HasFatalFailure()) return;
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 3);
  auto camera = open_openni2(*parse_camera_address("openni2:" + file));
  if (!camera.ok()) {  // the library may need what stood at its end
    EXPECT_THAT(camera.error().text(), testing::HasSubstr("room.oni"));
    return;
  }
  FramePool pool((*camera)->intrinsics(), 1);
  Frame frame = pool.acquire();
  std::vector<Grab> said;
  for (int tries = 0; tries < 400 && (said.empty() || said.back() != Grab::end); ++tries)
    if (const Grab grab = (*camera)->grab(frame, 100ms); grab != Grab::timeout) said.push_back(grab);
  ASSERT_GE(said.size(), 2u);
  EXPECT_EQ(said.back(), Grab::end);
  EXPECT_LT((*camera)->counters().frames, 8u);
}

}  // namespace
}  // namespace onemap::hal
#endif
