// What a mapper makes of four streams, in numbers that a change of the code must not change: refactoring, speeding up
// and moving rooms leave the map, the trajectory and the keyframes as they are. A change of the algorithms changes
// them; then the new numbers come from a release build, and the commit says why.
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "hal/backends.hpp"
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/submap_digest.hpp"

namespace onemap::mapping {
namespace {

struct Pin {
  std::uint64_t map = 0, poses = 0, keyframes = 0;
  bool operator==(const Pin&) const = default;
};

void PrintTo(const Pin& pin, std::ostream* out) {
  *out << std::hex << "{0x" << pin.map << ", 0x" << pin.poses << std::dec << ", " << pin.keyframes << "}";
}

// FNV-1a over the bytes that leave the robot.
struct Digest {
  std::uint64_t value = 0xcbf29ce484222325u;
  void add(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) value = (value ^ byte) * 0x100000001b3u;
  }
};

Pin walk(const std::string& address) {
  const std::array<hal::Backend, 2> backends{
      {{"replay", "", hal::open_replay}, {"simulated", "", hal::open_simulated}}};
  auto camera = hal::open_camera(backends, address);
  if (!camera) {
    ADD_FAILURE() << camera.error().text();
    return {};
  }
  hal::FramePool pool((*camera)->intrinsics(), 2);
  LocalMapper mapper({}, (*camera)->intrinsics());
  KeyframeRecord keyframe;
  TrajectoryRecord poses;
  SubmapRecord submap;
  Digest digest;
  const auto drain = [&] {
    while (mapper.take_keyframe(keyframe)) {
    }
    while (mapper.take_poses(poses)) digest.add(encode(poses));
    while (mapper.take_submap(submap)) {
    }
  };
  for (hal::Grab grab = hal::Grab::frame; grab != hal::Grab::end;) {
    hal::Frame frame = pool.acquire();
    grab = (*camera)->grab(frame, std::chrono::milliseconds(0));
    if (grab != hal::Grab::frame) continue;
    mapper.process(frame.view());
    drain();
  }
  mapper.finish();
  drain();
  return {test::submap_digest(mapper), digest.value, mapper.counters().keyframes};
}

// A recording's walk; under a sanitizer it takes minutes, and the simulated rooms run the same code.
std::optional<Pin> recorded(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(ONEMAP_SHARED_DIR) / "data" / name;
  if (!std::filesystem::exists(folder) || !std::string(ONEMAP_SANITIZE).empty()) return std::nullopt;
  return walk("replay:" + folder.string());
}

TEST(Pinned, TheDeskOfFr1Xyz) {
  const auto pin = recorded("fr1_xyz");
  if (!pin) GTEST_SKIP() << "the recording fr1_xyz is not here, or a sanitizer runs";
  EXPECT_EQ(*pin, (Pin{0x4938f18e8a54a9ed, 0xa79e66e9a8ad455e, 36}));
}

TEST(Pinned, TheTurningCameraOfFr1Rpy) {
  const auto pin = recorded("fr1_rpy_a");
  if (!pin) GTEST_SKIP() << "the recording fr1_rpy_a is not here, or a sanitizer runs";
  EXPECT_EQ(*pin, (Pin{0xeaff4a13386d2095, 0x94feef5dacebe12a, 39}));
}

TEST(Pinned, TheSimulatedLivingRoom) {
  EXPECT_EQ(walk("simulated:living-room?frames=120&width=320&height=240"),
            (Pin{0xba7f9a95d838a072, 0x9e9f390347aedb79, 12}));
}

TEST(Pinned, TheSimulatedOffice) {
  EXPECT_EQ(walk("simulated:office?frames=120&seed=5&width=320&height=240"),
            (Pin{0x12673d5a0aa1db2c, 0x22543979b60cc7c7, 11}));
}

}  // namespace
}  // namespace onemap::mapping
