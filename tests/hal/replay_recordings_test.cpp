// The replay backend on the real recordings, when they are there.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "hal/backends/replay.hpp"
#include "hal/backends/replay/lists.hpp"
#include "hal/frame_pool.hpp"
#include "support/text_of.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

class ReplayRecordings : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder())) GTEST_SKIP() << "the recording " << folder() << " is not here";
  }
  std::string folder() const { return std::string(ONEMAP_SHARED_DIR) + "/data/" + GetParam(); }
  std::unique_ptr<DepthCamera> open(const std::string& suffix) const {
    const auto address = parse_camera_address("replay:" + folder() + suffix);
    auto camera = open_replay(address.value());
    EXPECT_TRUE(camera.ok()) << camera.error().text();
    return camera.ok() ? std::move(*camera) : nullptr;
  }
};

TEST_P(ReplayRecordings, PairsAsTheirAssociationsSay) {
  const auto read = [&](const std::string& name) { return test::text_of(folder() + "/" + name); };
  const replay::ImageList color = replay::parse_image_list(read("rgb.txt"), "rgb.txt");
  const replay::ImageList depth = replay::parse_image_list(read("depth.txt"), "depth.txt");
  const replay::PairList expected = replay::parse_associations(read("associations.txt"), "associations.txt");
  ASSERT_TRUE(color.problems.empty() && depth.problems.empty() && expected.problems.empty());
  const std::vector<replay::ListedPair> pairs = replay::associate(color.images, depth.images, 20ms);
  ASSERT_EQ(pairs.size(), expected.pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(pairs[i].color.path, expected.pairs[i].color.path);
    EXPECT_EQ(pairs[i].color.time, expected.pairs[i].color.time);
    EXPECT_EQ(pairs[i].depth.path, expected.pairs[i].depth.path);
    EXPECT_EQ(pairs[i].depth.time, expected.pairs[i].depth.time);
  }
  auto camera = open("");
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->frames_expected(), expected.pairs.size());
  EXPECT_EQ(camera->counters().unmatched, 0u);
}

TEST_P(ReplayRecordings, PlaysACut) {
  auto camera = open(":100:110");
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->intrinsics().width, 640);
  EXPECT_EQ(camera->intrinsics().height, 480);
  EXPECT_DOUBLE_EQ(camera->intrinsics().fx, 517.306408);
  EXPECT_EQ(camera->frames_expected(), 10u);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  FrameTime last{};
  for (std::uint64_t i = 0; i < 10; ++i) {
    ASSERT_EQ(camera->grab(frame, 0ms), Grab::frame) << camera->last_error().text();
    EXPECT_EQ(frame.index, i);
    EXPECT_GT(frame.colour_time, last);
    last = frame.colour_time;
    std::size_t near = 0;
    for (const std::uint16_t d : frame.depth()) near += d > 2000 && d < 25000;  // 0.4 m to 5 m
    EXPECT_GT(near, 640u * 480u / 3);
  }
  EXPECT_EQ(camera->grab(frame, 0ms), Grab::end);
  EXPECT_EQ(camera->counters().frames, 10u);
  EXPECT_EQ(camera->counters().bad, 0u);
}

INSTANTIATE_TEST_SUITE_P(Shared, ReplayRecordings, testing::Values("fr1_xyz", "fr1_rpy_a"));

}  // namespace
}  // namespace onemap::hal
