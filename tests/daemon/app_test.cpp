// The life cycle with cameras that misbehave: what there is is written, and the exit says what happened.
#include "daemon/app.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <new>
#include <thread>

#include "hal/backends/simulated.hpp"
#include "support/program.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;

// Thirty good frames, and then an exception from where nobody expects one.
class FaultyCamera final : public hal::DepthCamera {
 public:
  explicit FaultyCamera(std::unique_ptr<hal::DepthCamera> good) : good_(std::move(good)) {}
  const hal::Intrinsics& intrinsics() const override { return good_->intrinsics(); }
  hal::Grab grab(hal::Frame& into, std::chrono::milliseconds timeout) override {
    if (++frames_ > 30) throw std::bad_alloc();
    return good_->grab(into, timeout);
  }
  const Error& last_error() const override { return good_->last_error(); }
  hal::CameraCounters counters() const override { return {good_->counters().frames, 0, 5, 7}; }
  bool live() const override { return good_->live(); }
  std::uint64_t frames_expected() const override { return good_->frames_expected(); }
  std::string description() const override { return "a camera with a fault"; }
  std::string limits() const override { return "is on USB 2"; }

 private:
  std::unique_ptr<hal::DepthCamera> good_;
  int frames_ = 0;
};

Result<std::unique_ptr<hal::DepthCamera>> open_faulty(const hal::CameraAddress& address) {
  auto good = hal::open_simulated(address);
  if (!good) return good.error();
  return std::unique_ptr<hal::DepthCamera>(std::make_unique<FaultyCamera>(std::move(*good)));
}

constexpr std::array kFaulty{hal::Backend{"faulty", "throws after 30 frames", open_faulty}};

Config config_for(const TempFolder& out, const std::string& camera) {
  Config config;
  config.id = "robot";
  config.camera = camera;
  config.out = out.path().string();
  config.once = true;
  config.speed = {true, 1};
  return config;
}

class AppTest : public testing::TestWithParam<bool> {};

TEST_P(AppTest, AThreadThatThrowsEndsTheWorkAndWhatThereIsIsWritten) {
  const TempFolder out;
  StopSignals signals;
  Log log("robot");
  Config config = config_for(out, "faulty:living-room?robot=1&robots=3&frames=60&seed=3");
  if (GetParam()) config.listen = "127.0.0.1:0";  // with a team's threads
  testing::internal::CaptureStderr();
  EXPECT_EQ(App(config, log, kFaulty).run(signals), Exit::failed);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("capture: out of memory"));
  EXPECT_THAT(said, HasSubstr("the camera is on USB 2\n")) << "when it was opened";
  const auto status = test::read_json(out / "status.json");
  EXPECT_EQ(status.at("images_unmatched"), 5);
  EXPECT_EQ(status.at("frames_missed"), 7);
  EXPECT_GE(test::lines(out / "trajectory.txt"), 20u);
  EXPECT_TRUE(std::filesystem::exists(out / "local.ply"));
  EXPECT_EQ(test::read_json(out / "report.json").at("robots").size(), 1u);
}
INSTANTIATE_TEST_SUITE_P(AloneAndInATeam, AppTest, testing::Bool());

}  // namespace
}  // namespace onemap::daemon
