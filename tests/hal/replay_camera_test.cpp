// The replay backend on sequences that the test writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "hal/backends/replay.hpp"
#include "hal/encoded_images.hpp"
#include "support/temp_folder.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kWidth = 16, kHeight = 12;
constexpr const char* kCalibration = "fx 20\nfy 21\ncx 8\ncy 6\nk1 0.1\n";

class ReplayCameraTest : public testing::Test {
 protected:
  void write_color(const std::string& name, int seed) {
    folder_.write(name, test::encode_png(kWidth, kHeight, {}, test::picture(kWidth, kHeight, seed)));
  }
  void write_depth(const std::string& name, int seed) {
    folder_.write(name, test::encode_depth_png(kWidth, kHeight, test::ramp(kWidth, kHeight, seed)));
  }
  // Frames 0 to count-1 at i * 0.1 s, depth 4 ms later.
  void write_tum(int count) {
    std::string rgb = "# colour\n", depth = "# depth\n";
    for (int i = 0; i < count; ++i) {
      const std::string n = std::to_string(i);
      write_color("rgb/" + n + ".png", i);
      write_depth("depth/" + n + ".png", i);
      rgb += n + ".1 rgb/" + n + ".png\n";
      depth += n + ".104 depth/" + n + ".png\n";
    }
    folder_.write("rgb.txt", rgb);
    folder_.write("depth.txt", depth);
    folder_.write("calibration.txt", kCalibration);
  }
  void write_seven_scenes(const std::vector<int>& frames) {
    for (const int i : frames) {
      char name[32];
      std::snprintf(name, sizeof name, "frame-%06d", i);
      write_color(name + std::string(".color.png"), i);
      write_depth(name + std::string(".depth.png"), i);
      folder_.write(name + std::string(".pose.txt"), "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    }
  }

  Result<std::unique_ptr<DepthCamera>> try_open(const std::string& suffix = "") const {
    const auto address = parse_camera_address("replay:" + folder_.path().string() + suffix);
    if (!address) return address.error();
    return open_replay(*address);
  }
  void open(const std::string& suffix = "") {
    auto camera = try_open(suffix);
    ASSERT_TRUE(camera.ok()) << camera.error().text();
    camera_ = std::move(*camera);
    pool_.emplace(camera_->intrinsics(), 1);
  }
  std::string open_error(const std::string& suffix = "") const {
    const auto camera = try_open(suffix);
    return camera.ok() ? "" : camera.error().text();
  }

  struct Played {
    std::vector<FrameTime> times, depth_times;
    std::vector<std::uint64_t> indices;
    std::vector<std::string> errors;
    std::vector<int> seeds;  // of the pictures, read back from the first pixel
  };
  Played play() {
    Played played;
    Frame frame = pool_->acquire();
    while (true) {
      const Grab grab = camera_->grab(frame, 0ms);
      if (grab == Grab::end) break;
      if (grab == Grab::bad) played.errors.push_back(camera_->last_error().text());
      if (grab != Grab::frame) continue;
      played.times.push_back(frame.colour_time);
      played.depth_times.push_back(frame.depth_time);
      played.indices.push_back(frame.index);
      played.seeds.push_back(frame.rgb()[0]);
      EXPECT_TRUE(std::ranges::equal(frame.rgb(), test::picture(kWidth, kHeight, frame.rgb()[0])));
    }
    EXPECT_EQ(camera_->grab(frame, 0ms), Grab::end);  // and stays so
    EXPECT_EQ(camera_->counters().frames, played.times.size());
    EXPECT_EQ(camera_->counters().bad, played.errors.size());
    EXPECT_EQ(camera_->frames_expected(), 0u);
    return played;
  }

  test::TempFolder folder_;
  std::unique_ptr<DepthCamera> camera_;
  std::optional<FramePool> pool_;
};

TEST_F(ReplayCameraTest, PlaysATumSequence) {
  write_tum(3);
  open();
  EXPECT_EQ(camera_->frames_expected(), 3u);
  const Intrinsics& k = camera_->intrinsics();
  EXPECT_EQ(k.width, kWidth);
  EXPECT_EQ(k.height, kHeight);
  EXPECT_EQ(k.fx, 20);
  EXPECT_EQ(k.k1, 0.1);
  EXPECT_EQ(k.depth_scale, 5000);
  EXPECT_THAT(camera_->description(),
              testing::AllOf(HasSubstr("TUM"), HasSubstr("16x12"), HasSubstr("calibration.txt")));
  const Played played = play();
  EXPECT_THAT(played.errors, testing::IsEmpty());
  EXPECT_THAT(played.seeds, testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(played.indices, testing::ElementsAre(0u, 1u, 2u));
  EXPECT_EQ(played.times[2], frame_time_from_ns(2'100'000'000));
  EXPECT_EQ(played.depth_times[2], played.times[2]) << "unless its own time is asked for";
  open("?depth_time=own");
  EXPECT_EQ(play().depth_times[2], frame_time_from_ns(2'104'000'000));
  EXPECT_THAT(open_error("?depth_time=later"), HasSubstr("neither own nor colour"));
  EXPECT_FALSE(camera_->live());
  EXPECT_EQ(camera_->depth_noise(), DepthNoise{});
  EXPECT_EQ(camera_->counters().unmatched, 0u);
}

TEST_F(ReplayCameraTest, DepthIsTheFilesDepth) {
  write_tum(1);
  open();
  Frame frame = pool_->acquire();
  ASSERT_EQ(camera_->grab(frame, 0ms), Grab::frame);
  EXPECT_TRUE(std::ranges::equal(frame.depth(), test::ramp(kWidth, kHeight, 0)));
}

TEST_F(ReplayCameraTest, PlaysACut) {
  write_tum(5);
  open(":1:4");
  EXPECT_EQ(camera_->frames_expected(), 3u);
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(played.indices, testing::ElementsAre(0u, 1u, 2u));
}

TEST_F(ReplayCameraTest, CutsOutsideTheRecordingAreErrors) {
  write_tum(5);
  for (const char* cut : {":0:6", ":4:4", ":3:2", ":5:6"})
    EXPECT_THAT(open_error(cut), testing::AllOf(HasSubstr("0 to 5"), HasSubstr(cut))) << cut;
  for (const char* cut : {":1", ":a:b", ":-1:3", ":1:", "::"})
    EXPECT_THAT(open_error(cut), HasSubstr("expected replay:DIR or replay:DIR:FROM:TO")) << cut;
}

TEST_F(ReplayCameraTest, AFolderNameMayHoldColonsAndDigits) {
  write_tum(2);
  std::filesystem::create_directory(folder_ / "a:1:b");
  for (const char* name : {"rgb", "depth", "rgb.txt", "depth.txt", "calibration.txt"})
    std::filesystem::rename(folder_ / name, folder_ / "a:1:b" + "/" + name);
  open("/a:1:b:0:1");
  EXPECT_THAT(play().seeds, testing::ElementsAre(0));
}

TEST_F(ReplayCameraTest, BadFramesAreNamedAndTheRestGoesOn) {
  write_tum(6);
  std::filesystem::remove(folder_ / "rgb/0.png");  // missing, and the first
  folder_.write("depth/1.png", "not a picture");   // odd
  const test::Bytes jpeg = test::encode_jpeg(kWidth, kHeight, 3, test::picture(kWidth, kHeight, 0));
  folder_.write("rgb/2.png", std::span(jpeg).first(jpeg.size() - 40));             // truncated
  folder_.write("rgb/3.png", test::encode_png(8, 8, {}, test::picture(8, 8, 0)));  // another size
  std::filesystem::remove(folder_ / "depth/4.png");
  std::filesystem::create_directory(folder_ / "depth/4.png");  // a folder where a file should be
  open();
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(5));
  EXPECT_THAT(played.indices, testing::ElementsAre(5u));
  ASSERT_EQ(played.errors.size(), 5u);
  EXPECT_THAT(played.errors[0],
              testing::AllOf(HasSubstr(folder_ / "rgb/0.png"), HasSubstr("No such file"), HasSubstr("rgb.txt:2")));
  EXPECT_THAT(played.errors[1], testing::AllOf(HasSubstr("depth/1.png: not a PNG"), HasSubstr("depth.txt:3")));
  EXPECT_THAT(played.errors[2], testing::AllOf(HasSubstr("rgb/2.png: JPEG"), HasSubstr("rgb.txt:4")));
  EXPECT_THAT(played.errors[3], HasSubstr("rgb/3.png: the image is 8x8, expected 16x12"));
  EXPECT_THAT(played.errors[4], HasSubstr("depth/4.png: cannot read: not a regular file"));
}

TEST_F(ReplayCameraTest, WithoutOneGoodFrameItDoesNotOpen) {
  write_tum(2);
  std::filesystem::remove_all(folder_ / "depth");
  EXPECT_THAT(open_error(), testing::AllOf(HasSubstr("depth/0.png"), HasSubstr("no other frame can be read")));
}

TEST_F(ReplayCameraTest, BadLinesComeFirstWithTheirPlace) {
  write_tum(2);
  folder_.write("rgb.txt", "0.1 rgb/0.png\r\n\r\nrubbish\r\n1.1 rgb/1.png # good\r\n");
  open();
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(0, 1));
  ASSERT_EQ(played.errors.size(), 1u);
  EXPECT_THAT(played.errors[0], HasSubstr(folder_ / "rgb.txt" + ":3: 1 words"));
}

TEST_F(ReplayCameraTest, UnsortedListsPlayInOrderAndUnmatchedAreCounted) {
  write_tum(4);
  folder_.write("rgb.txt", "3.1 rgb/3.png\n0.1 rgb/0.png\n2.2 rgb/2.png\n1.1 rgb/1.png\n");
  open();
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(0, 1, 3));
  EXPECT_TRUE(std::is_sorted(played.times.begin(), played.times.end()));
  EXPECT_EQ(camera_->counters().unmatched, 2u);  // colour 2.2 and depth 2.104
}

TEST_F(ReplayCameraTest, MaxDtIsAnOption) {
  write_tum(2);
  folder_.write("depth.txt", "0.15 depth/0.png\n1.104 depth/1.png\n");
  open();
  EXPECT_THAT(play().seeds, testing::ElementsAre(1));
  open("?max_dt=0.06");
  EXPECT_THAT(play().seeds, testing::ElementsAre(0, 1));
  EXPECT_THAT(open_error("?max_dt=0.001"), HasSubstr("4 images without a partner"));
  EXPECT_THAT(open_error("?max_dt=x"), HasSubstr("max_dt"));
  EXPECT_THAT(open_error("?max_dt=2"), HasSubstr("max_dt"));
}

TEST_F(ReplayCameraTest, AssociationsServeWhenTheListsAreAbsent) {
  write_tum(3);
  std::filesystem::remove(folder_ / "depth.txt");
  folder_.write("associations.txt", "0.5 rgb/2.png 0.1 depth/0.png\n0.7 rgb/1.png 0.7 depth/2.png\nbroken\n");
  open();
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(2, 1));
  ASSERT_EQ(played.errors.size(), 1u);
  EXPECT_THAT(played.errors[0], HasSubstr("associations.txt:3"));
}

TEST_F(ReplayCameraTest, OptionsGoOverTheCalibration) {
  write_tum(1);
  open("?fx=99&depth_scale=1000");
  EXPECT_EQ(camera_->intrinsics().fx, 99);
  EXPECT_EQ(camera_->intrinsics().fy, 21);
  EXPECT_EQ(camera_->intrinsics().depth_scale, 1000);
  std::filesystem::remove(folder_ / "calibration.txt");
  open("?fx=10&fy=12&cx=3&cy=4");
  EXPECT_EQ(camera_->intrinsics().cy, 4);
  EXPECT_THAT(open_error("?fx=1&fy=2"), testing::AllOf(HasSubstr("lacks cx cy"), HasSubstr("calibration.txt")));
  EXPECT_THAT(open_error(), HasSubstr("lacks fx fy cx cy"));
  EXPECT_THAT(open_error("?fx=zero"), HasSubstr("fx: 'zero' is not a number"));
  EXPECT_THAT(open_error("?speed=2"), HasSubstr("unknown option 'speed'"));
}

TEST_F(ReplayCameraTest, ABadCalibrationStopsWithItsLine) {
  write_tum(1);
  folder_.write("calibration.txt", "fx 1\nfocus 3\n");
  EXPECT_THAT(open_error(), HasSubstr(folder_ / "calibration.txt" + ":2: unknown key 'focus'"));
}

TEST_F(ReplayCameraTest, ACalibrationOfOtherImagesStopsWithItsLine) {
  write_tum(1);  // 16x12
  const std::string file = folder_ / "calibration.txt";
  const std::pair<const char*, const char*> cases[] = {
      {"fx 20\nfy 21\ncx 319.5\ncy 6\n", ":3: cx: 319.5 is not within -0.5 to 15.5, for images of 16x12"},
      {"fx 20\nfy 21\ncx 8\n\ncy 12\n", ":5: cy: 12 is not within -0.5 to 11.5"},
      {"fx 525\nfy 21\ncx 8\ncy 6\n", ":1: fx: 525 is not within 1.6 to 320"},
      {"fx 20\nfy 1.5\ncx 8\ncy 6\n", ":2: fy: 1.5 is not within"}};
  for (const auto& [text, expected] : cases) {
    folder_.write("calibration.txt", text);
    EXPECT_THAT(open_error(), HasSubstr(file + expected));
  }
  folder_.write("calibration.txt", kCalibration);
  EXPECT_THAT(open_error("?cx=99"), testing::AllOf(HasSubstr("?cx=99"), HasSubstr("cx: 99 is not within")));
}

TEST_F(ReplayCameraTest, PlaysSevenScenes) {
  write_seven_scenes({30, 0, 3});
  std::filesystem::remove(folder_ / "frame-000000.depth.png");
  open();
  EXPECT_EQ(camera_->intrinsics().fx, 585);
  EXPECT_EQ(camera_->intrinsics().cx, 320);
  EXPECT_EQ(camera_->intrinsics().depth_scale, 1000);
  EXPECT_THAT(camera_->description(), testing::AllOf(HasSubstr("7-Scenes layout"), HasSubstr("defaults")));
  const Played played = play();
  EXPECT_THAT(played.seeds, testing::ElementsAre(3, 30));
  EXPECT_THAT(played.times, testing::ElementsAre(frame_time_from_ns(100'000'000), frame_time_from_ns(1'000'000'000)));
  EXPECT_EQ(camera_->counters().unmatched, 1u);
}

TEST_F(ReplayCameraTest, SevenScenesMarksMissingDepthWith65535) {
  write_seven_scenes({0});
  std::vector<std::uint16_t> depth = test::ramp(kWidth, kHeight, 0);
  depth[5] = 65535;
  depth[6] = 65534;
  folder_.write("frame-000000.depth.png", test::encode_depth_png(kWidth, kHeight, depth));
  open();
  Frame frame = pool_->acquire();
  ASSERT_EQ(camera_->grab(frame, 0ms), Grab::frame);
  depth[5] = 0;
  EXPECT_TRUE(std::ranges::equal(frame.depth(), depth));
}

TEST_F(ReplayCameraTest, TheLayoutCanBeForced) {
  write_tum(2);
  write_seven_scenes({7});
  open();
  EXPECT_THAT(play().seeds, testing::ElementsAre(0, 1));
  open("?layout=7scenes");
  EXPECT_THAT(play().seeds, testing::ElementsAre(7));
  EXPECT_THAT(open_error("?layout=kitti"), HasSubstr("neither tum nor 7scenes"));
}

TEST_F(ReplayCameraTest, FoldersThatAreNoRecordings) {
  EXPECT_THAT(open_error(), HasSubstr("not a recording"));
  EXPECT_THAT(open_error("/nowhere"), HasSubstr("no folder"));
  folder_.write("rgb.txt", "what\n");
  folder_.write("depth.txt", "");
  folder_.write("calibration.txt", kCalibration);
  EXPECT_THAT(open_error(), HasSubstr("rgb.txt:1"));
}

}  // namespace
}  // namespace onemap::hal
