#include "mapping/local/focal_check.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>

#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"

namespace onemap::mapping {
namespace {

using Points = std::vector<Vector3d>;

// The same points in two views that are `degrees` apart, by a lens that claims `ratio` of its focal length.
std::pair<Points, Points> views(double ratio, double degrees, std::mt19937& random, std::size_t wrong = 0) {
  std::uniform_real_distribution<double> across(-1.2, 1.2), along(1.5, 3.5);
  const Matrix3d R = Eigen::AngleAxisd(degrees * M_PI / 180, Vector3d::UnitY()).toRotationMatrix();
  std::pair<Points, Points> out;
  for (std::size_t i = 0; i < 90; ++i) {
    const Vector3d a(across(random), across(random), along(random));
    Vector3d b = R * a + Vector3d(0.2, 0, 0.1);
    if (i < wrong) b = {across(random), across(random), along(random)};
    const auto claimed = [&](const Vector3d& p) { return Vector3d(p.x() / ratio, p.y() / ratio, p.z()); };
    out.first.push_back(claimed(a));
    out.second.push_back(claimed(b));
  }
  return out;
}

FocalEstimate after(double ratio, double degrees, int pairs, std::size_t wrong = 0) {
  std::mt19937 random(7);
  FocalCheck check(500);
  for (int i = 0; i < pairs; ++i) {
    const auto [a, b] = views(ratio, degrees, random, wrong);
    check.add(a, b);
  }
  return check.estimate();
}

TEST(FocalCheck, FindsTheClaimedShareAlsoAmongWrongMatches) {
  for (const double ratio : {0.8, 0.95, 1.0, 1.25}) {
    EXPECT_NEAR(after(ratio, 20, 12).ratio, ratio, 1e-6);
    EXPECT_NEAR(after(ratio, 20, 12, 12).ratio, ratio, 0.05 * ratio);
    EXPECT_EQ(after(ratio, 20, 12).wrong(), ratio == 0.8 || ratio == 1.25);
  }
}

TEST(FocalCheck, AFewViewsAreNotEnough) {
  EXPECT_EQ(after(0.8, 20, 3).views, 3);
  EXPECT_FALSE(after(0.8, 20, 3).wrong());
}

TEST(FocalCheck, ViewsInOneDirectionSayNothing) {
  EXPECT_EQ(after(0.8, 0, 20).views, 0);
  EXPECT_FALSE(after(0.8, 0, 20).wrong());
  FocalCheck check(500);
  check.add({}, {});
  EXPECT_EQ(check.estimate().views, 0);
}

// What a mapper says of the lens after a simulated room or a recording.
FocalEstimate seen(const std::string& text) {
  const hal::CameraAddress address = *hal::parse_camera_address(text);
  const auto camera =
      std::move(text.starts_with("replay") ? hal::open_replay(address) : hal::open_simulated(address)).value();
  LocalMapperConfig config;
  config.max_keyframes = 40;
  LocalMapper mapper(config, camera->intrinsics());
  hal::FramePool pool(camera->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  while (camera->grab(frame, {}) == hal::Grab::frame) mapper.process(frame.view());
  return mapper.focal();
}

// Of a right lens, one of 0.8 and one of 1.25 of its focal length; `within`: of the ratio itself.
void expect_told(const std::array<FocalEstimate, 3>& estimates, double within) {
  constexpr std::array<double, 3> kRatios{1, 0.8, 1.25};
  for (std::size_t i = 0; i < kRatios.size(); ++i) {
    EXPECT_NEAR(estimates[i].ratio, kRatios[i], within * kRatios[i]);
    EXPECT_EQ(estimates[i].wrong(), i != 0) << kRatios[i] << ": " << estimates[i].views << " views";
  }
}

TEST(FocalCheck, AMapperNoticesAWrongLensInARoomAndARightOneIsRight) {
  const std::string room = "simulated:living-room?seed=3&fps=15&frames=70";
  expect_told({seen(room), seen(room + "&fx_scale=0.8"), seen(room + "&fx_scale=1.25")}, 0.03);
}

// A hand-held camera that turned fast. The recording's own depth is some hundredths off, which is no alarm.
TEST(FocalCheck, ARecordingWithAWrongLensIsNoticedAndWithItsOwnIsNot) {
  const std::filesystem::path folder = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/fr1_rpy_a";
  if (!std::filesystem::exists(folder / "depth.txt")) GTEST_SKIP() << "recording not found: " << folder;
  const auto with = [&](double share) {
    return seen("replay:" + folder.string() + ":0:80?fx=" + std::to_string(517.306408 * share) +
                "&fy=" + std::to_string(516.469215 * share));
  };
  expect_told({with(1), with(0.8), with(1.25)}, 0.07);  // a real camera's depth reads some per cent low
}

}  // namespace
}  // namespace onemap::mapping
