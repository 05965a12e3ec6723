// A simulated room mapped through the real V4L2 calls: the frames of `simulated:` come out of a camera that umockdev
// plays, which is unplugged on the way, and the trajectory is the one that `simulated:` gives itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "hal/backends/simulated.hpp"
#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/v4l2/mock_uvc.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/temp_folder.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using test::MockMode;
using test::MockNodeConfig;

constexpr std::uint64_t kFrames = 60, kUnpluggedAfter = 30;
constexpr imaging::ImageSize kSmall{320, 240};

std::string room_of(imaging::ImageSize size) {
  return fmt::format("simulated:living-room?seed=3&frames={}&width={}&height={}", kFrames, size.width, size.height);
}
std::string calibration_of(imaging::ImageSize size) {
  return fmt::format("width {}\nheight {}\nfx {}\nfy {}\ncx {}\ncy {}\ndepth_scale 5000\n", size.width, size.height,
                     525 * size.width / 640.0, 525 * size.width / 640.0, (size.width - 1) / 2.0,
                     (size.height - 1) / 2.0);
}

using Trajectory = std::vector<mapping::Vector3d>;

mapping::LocalMapperConfig config() {
  mapping::LocalMapperConfig config;
  config.max_keyframes = 40;
  config.map.budget_bytes = 24u << 20;
  return config;
}

// The room's frames one after the other, grey, as both nodes send them.
class Room {
 public:
  explicit Room(imaging::ImageSize size)
      : camera_(open_text(open_simulated, room_of(size)).value()),
        pool_(camera_->intrinsics(), 1),
        frame_(pool_.acquire()) {}
  bool next() {
    if (camera_->grab(frame_, 0ms) != Grab::frame) return false;
    for (std::size_t i = 0; i < frame_.rgb().size(); i += 3) {
      const std::uint8_t* p = &frame_.rgb()[i];
      const auto grey = static_cast<std::uint8_t>((p[0] + 2 * p[1] + p[2]) / 4);
      std::fill_n(&frame_.rgb()[i], 3, grey);
    }
    return true;
  }
  FrameView view() const { return frame_.view(); }

 private:
  std::unique_ptr<DepthCamera> camera_;
  FramePool pool_;
  Frame frame_;
};

Trajectory straight_through(imaging::ImageSize size, std::uint64_t frames) {
  Room room(size);
  mapping::LocalMapper mapper(config(), *room.view().intrinsics);
  Trajectory trajectory;
  while (trajectory.size() < frames && room.next()) {
    const mapping::FrameReport report = mapper.process(room.view());
    EXPECT_EQ(report.state, mapping::TrackState::tracking);
    trajectory.push_back(report.T_robot_camera.t);
  }
  return trajectory;
}

// Both nodes of the mock send the frames of one room in step, again from the same one when they start anew; the first
// that asks for a frame takes it from the room, and the last stays.
class RoomFeed {
 public:
  explicit RoomFeed(imaging::ImageSize size) : size_(size), room_(size) {}
  MockNodeConfig node(bool depth) {
    MockNodeConfig config;
    config.formats = {depth ? V4L2_PIX_FMT_Z16 : V4L2_PIX_FMT_GREY};
    config.sizes = {{size_.width, size_.height}};
    config.content = [this, depth, first = std::uint64_t{0}](const MockMode&, std::uint32_t sequence, std::uint8_t* out,
                                                             std::uint32_t stride) mutable {
      if (sequence == 0 && starts_++ % 2 == 0) start_ = taken_;
      if (sequence == 0) first = start_;
      send(first + sequence, depth, out, stride);
    };
    return config;
  }

 private:
  void send(std::uint64_t number, bool depth, std::uint8_t* out, std::uint32_t stride) {
    for (; taken_ <= number && room_.next(); ++taken_) {
    }
    const FrameView view = room_.view();
    const auto width = static_cast<std::size_t>(size_.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(size_.height); ++y) {
      if (depth) std::memcpy(out + y * stride, &view.depth[y * width], 2 * width);
      for (std::size_t x = 0; !depth && x < width; ++x) out[y * stride + x] = view.rgb[3 * (y * width + x)];
    }
  }
  const imaging::ImageSize size_;
  Room room_;
  std::uint64_t taken_ = 0, starts_ = 0, start_ = 0;
};

TEST(V4l2Room, IsMappedAsTheSimulationIsAndTheMapResumesAfterUnplugging) {
  if (!test::MockTestbed::wrapped()) GTEST_SKIP() << "umockdev-wrapper is not around this process (package umockdev)";
  test::TempFolder folder;
  folder.write("calibration.txt", calibration_of(kSmall));
  test::MockTestbed testbed;
  RoomFeed feed(kSmall);
  test::MockUvc mock(testbed, 1, "8086:0b07", "Mock depth camera", feed.node(true), feed.node(false));
  mock.plug(0);
  auto opened = open_text(open_v4l2, "v4l2:?calibration=" + (folder / "calibration.txt"));
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  DepthCamera& camera = **opened;
  FramePool pool(camera.intrinsics(), 1);
  mapping::LocalMapper mapper(config(), camera.intrinsics(), camera.depth_noise());
  const Trajectory expected = straight_through(kSmall, kFrames);
  ASSERT_EQ(expected.size(), kFrames);
  Trajectory found;
  bool was_gone = false;
  for (int asked = 0; found.size() < kFrames && asked < 3000; ++asked) {
    Frame frame = pool.acquire();
    const Grab grab = camera.grab(frame, 100ms);
    ASSERT_TRUE(grab == Grab::frame || grab == Grab::timeout || grab == Grab::gone) << camera.last_error().text();
    if (grab == Grab::gone && !was_gone) {
      was_gone = true;
      mock.plug(2);
    }
    if (grab != Grab::frame) continue;
    const mapping::FrameReport report = mapper.process(frame.view());
    ASSERT_EQ(report.state, mapping::TrackState::tracking) << found.size();
    found.push_back(report.T_robot_camera.t);
    frame = Frame{};
    if (found.size() == kUnpluggedAfter) mock.unplug();
  }
  EXPECT_TRUE(was_gone);
  ASSERT_EQ(found.size(), kFrames) << "the last frame stays, whatever was lost when it was unplugged";
  for (std::size_t i = 0; i < kUnpluggedAfter; ++i) EXPECT_LT((found[i] - expected[i]).norm(), 0.002) << "frame " << i;
  EXPECT_LT((found.back() - expected.back()).norm(), 0.01) << "where the walk ends";
}

// The same frames in other sizes give the same way to the bit: nothing on it is made for one size.
TEST(V4l2Room, IsMappedInLargerSizesAsTheSimulationIs) {
  if (!test::MockTestbed::wrapped()) GTEST_SKIP() << "umockdev-wrapper is not around this process (package umockdev)";
  constexpr std::uint64_t kSome = 8;
  for (const imaging::ImageSize size : {imaging::ImageSize{848, 480}, imaging::ImageSize{1280, 720}}) {
    test::TempFolder folder;
    folder.write("calibration.txt", calibration_of(size));
    test::MockTestbed testbed;
    RoomFeed feed(size);
    test::MockUvc mock(testbed, 1, "8086:0b07", "Mock depth camera", feed.node(true), feed.node(false));
    mock.plug(0);
    auto opened = open_text(open_v4l2, "v4l2:?calibration=" + (folder / "calibration.txt"));
    ASSERT_TRUE(opened.ok()) << opened.error().text();
    FramePool pool((*opened)->intrinsics(), 1);
    mapping::LocalMapper mapper(config(), (*opened)->intrinsics(), (*opened)->depth_noise());
    Trajectory found;
    Frame frame = pool.acquire();
    while (found.size() < kSome) {
      ASSERT_EQ((*opened)->grab(frame, 10s), Grab::frame) << (*opened)->last_error().text();
      const mapping::FrameReport report = mapper.process(frame.view());
      ASSERT_EQ(report.state, mapping::TrackState::tracking) << found.size();
      found.push_back(report.T_robot_camera.t);
    }
    EXPECT_EQ(found, straight_through(size, kSome)) << size.width;
    EXPECT_GT(found.back().norm(), 0.01) << "it walks";
  }
}

}  // namespace
}  // namespace onemap::hal
