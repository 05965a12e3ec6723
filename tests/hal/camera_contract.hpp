#pragma once
// What every camera promises (hal/depth_camera.hpp), as one suite for all backends, real, virtual and fake. A backend's
// test includes this, writes a Rig and says
//   INSTANTIATE_TYPED_TEST_SUITE_P(Name, CameraContract, Rig);
//
// A Rig sets up its own device or recording in the constructor and has:
//   std::string missing()             why it cannot run here; empty: it can
//   open(address, clock_offset = {})  the backend's open function, from text
//   std::string address(), other()    of two cameras, to be open at once
//   wrong_addresses()                 pairs of an address and what its error must say
//   formats()                         pairs of an address and what its camera must say of itself: every form in which
//                                     images of one scene come, the first that which address() has
//   static constexpr bool kLive       live() of its cameras
//   and when live: unplug(), plug(), pause(), resume() of the camera at address(); else kFrames, the stream's length
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/backends.hpp"

namespace onemap::hal {

using OpenFunction = Result<std::unique_ptr<DepthCamera>> (*)(const CameraAddress&);

inline Result<std::unique_ptr<DepthCamera>> open_text(OpenFunction open, const std::string& text,
                                                      Duration clock_offset = {}) {
  auto address = parse_camera_address(text);
  if (!address) return address.error();
  address->clock_offset = clock_offset;
  return open(*address);
}

template <class Rig>
class CameraContract : public testing::Test {
 protected:
  static constexpr std::chrono::milliseconds kPatient{20000}, kShort{60};

  void SetUp() override {
    const std::string missing = rig_.missing();
    if (!missing.empty()) GTEST_SKIP() << missing;
  }
  std::unique_ptr<DepthCamera> open(const std::string& address) {
    auto camera = rig_.open(address);
    if (!camera) {
      ADD_FAILURE() << camera.error().text();
      return nullptr;
    }
    return std::move(*camera);
  }
  // Asks until the answer is the one wanted, for a while; the last answer.
  static Grab grab_until(DepthCamera& camera, Frame& frame, Grab wanted) {
    Grab grab = camera.grab(frame, kShort);
    for (int i = 0; i < 300 && grab != wanted; ++i) grab = camera.grab(frame, kShort);
    return grab;
  }
  static bool has_content(const FrameView& view) {
    const auto differs = [](const auto& pixels) {
      return std::ranges::adjacent_find(pixels, std::not_equal_to{}) != pixels.end();
    };
    return differs(view.rgb) && differs(view.depth);
  }
  // Half of what has depth is nearer.
  static double median_m(const FrameView& view) {
    std::vector<std::uint16_t> seen;
    std::ranges::copy_if(view.depth, std::back_inserter(seen), [](std::uint16_t value) { return value != 0; });
    if (seen.empty()) return 0;
    const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
    std::ranges::nth_element(seen, middle);
    return *middle / view.intrinsics->depth_scale;
  }
  // Who went silent was not seen to go: it must be said who did.
  static void expect_seen_to_go(const DepthCamera& camera) {
    EXPECT_THAT(camera.last_error().text(), testing::Not(testing::HasSubstr("gave nothing")));
    EXPECT_FALSE(camera.last_error().text().empty());
  }

  Rig rig_;
};

TYPED_TEST_SUITE_P(CameraContract);

TYPED_TEST_P(CameraContract, OpensAndSaysWhatItIs) {
  const auto camera = this->open(this->rig_.address());
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->live(), TypeParam::kLive);
  EXPECT_FALSE(camera->description().empty());
  const Intrinsics& k = camera->intrinsics();
  EXPECT_GE(k.width, 16);
  EXPECT_GE(k.height, 12);
  EXPECT_GT(k.fx, 0);
  EXPECT_GT(k.depth_scale, 0);
  EXPECT_GT(camera->depth_noise().sigma_m(1.0), 0);
  EXPECT_EQ(camera->counters().frames, 0u);
  EXPECT_EQ(camera->frames_expected() == 0, TypeParam::kLive);
}

TYPED_TEST_P(CameraContract, WrongAddressesAreErrorsThatSayWhy) {
  for (const auto& [address, reason] : this->rig_.wrong_addresses()) {
    const auto camera = this->rig_.open(address);
    ASSERT_FALSE(camera.ok()) << address;
    EXPECT_THAT(camera.error().text(), testing::HasSubstr(reason)) << address;
  }
}

TYPED_TEST_P(CameraContract, FramesAreWholeAndTheirTimesIncrease) {
  const auto camera = this->open(this->rig_.address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  FrameTime last = FrameTime::min();  // a recording may begin at 0
  for (std::uint64_t i = 0; i < 10; ++i) {
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame) << camera->last_error().text();
    EXPECT_EQ(frame.index, i);
    EXPECT_GT(frame.colour_time, last);
    EXPECT_LE(std::chrono::abs(frame.depth_time - frame.colour_time), std::chrono::milliseconds(40));
    EXPECT_TRUE(this->has_content(frame.view())) << i;
    last = frame.colour_time;
  }
}

TYPED_TEST_P(CameraContract, EveryFormatGivesWholeFramesInMetres) {
  const auto formats = this->rig_.formats();
  ASSERT_GE(formats.size(), 2u);
  double first_m = 0;
  for (const auto& [address, says] : formats) {
    SCOPED_TRACE(address);
    const auto camera = this->open(address);
    ASSERT_TRUE(camera);
    EXPECT_THAT(camera->description(), testing::HasSubstr(says));
    const Intrinsics& k = camera->intrinsics();
    FramePool pool(k, 1);
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame) << camera->last_error().text();
    const FrameView view = frame.view();
    const auto pixels = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
    EXPECT_EQ(view.rgb.size(), 3 * pixels);
    EXPECT_EQ(view.depth.size(), pixels);
    EXPECT_TRUE(this->has_content(view));
    if (first_m == 0) first_m = this->median_m(view);
    EXPECT_GT(this->median_m(view), 0.6 * first_m);
    EXPECT_LT(this->median_m(view), 1.6 * first_m);
  }
}

TYPED_TEST_P(CameraContract, NoFrameIsLostWhenAllAreTaken) {
  const auto camera = this->open(this->rig_.address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 5);
  std::vector<Frame> held;  // as a pipeline holds some while the next are taken
  FrameTime first{}, last{};
  constexpr int kTaken = 20;
  for (int i = 0; i < kTaken; ++i) {
    if (held.size() == 4) held.erase(held.begin());
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame) << camera->last_error().text();
    last = frame.colour_time;
    if (i == 0) first = last;
    held.push_back(std::move(frame));
  }
  EXPECT_EQ(camera->counters().frames, 20u);
  EXPECT_EQ(camera->counters().missed, 0u);
  EXPECT_EQ(camera->counters().bad, 0u);
  EXPECT_LE(camera->counters().unmatched, 2u);  // at the start, one stream may be ahead
  if (TypeParam::kLive) {
    EXPECT_NEAR(to_seconds(last - first) / (kTaken - 1), 1.0 / 30, 0.002);
  }
}

TYPED_TEST_P(CameraContract, WaitingEndsWithTheTimeout) {
  const auto camera = this->open(this->rig_.address());
  ASSERT_TRUE(camera);
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  if constexpr (TypeParam::kLive) {
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame);
    this->rig_.pause();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::timeout), Grab::timeout);
    EXPECT_EQ(camera->grab(frame, this->kShort), Grab::timeout);
    EXPECT_EQ(camera->grab(frame, std::chrono::milliseconds(0)), Grab::timeout);
    this->rig_.resume();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::frame), Grab::frame) << camera->last_error().text();
  } else {
    std::size_t frames = 0;
    Grab grab = camera->grab(frame, this->kPatient);
    for (; grab == Grab::frame; grab = camera->grab(frame, this->kPatient)) ++frames;
    EXPECT_EQ(grab, Grab::end) << camera->last_error().text();
    EXPECT_EQ(frames, TypeParam::kFrames);
    EXPECT_EQ(camera->counters().bad, 0u);
    EXPECT_EQ(camera->grab(frame, this->kShort), Grab::end) << "and stays so";
    EXPECT_EQ(camera->frames_expected(), 0u);
  }
}

TYPED_TEST_P(CameraContract, AnUnpluggedCameraIsGoneAndComesBack) {
  if constexpr (!TypeParam::kLive) {
    GTEST_SKIP() << "nothing that could be unplugged";
  } else {
    const auto camera = this->open(this->rig_.address());
    ASSERT_TRUE(camera);
    FramePool pool(camera->intrinsics(), 3);
    Frame kept = pool.acquire(), frame = pool.acquire();
    ASSERT_EQ(camera->grab(kept, this->kPatient), Grab::frame);
    const FrameTime before = kept.colour_time;
    const Intrinsics k = camera->intrinsics();
    this->rig_.pause();  // so that it is unplugged while somebody waits
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::timeout), Grab::timeout);
    this->rig_.unplug();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::gone), Grab::gone);
    this->expect_seen_to_go(*camera);
    EXPECT_EQ(camera->grab(frame, this->kShort), Grab::gone);
    EXPECT_TRUE(this->has_content(kept.view())) << "a frame outlives its device";
    this->rig_.plug();
    ASSERT_EQ(this->grab_until(*camera, frame, Grab::frame), Grab::frame) << camera->last_error().text();
    EXPECT_GT(frame.colour_time, before);
    EXPECT_EQ(camera->intrinsics(), k);
    EXPECT_TRUE(this->has_content(frame.view()));
    this->rig_.unplug();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::gone), Grab::gone);
    this->rig_.plug();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::frame), Grab::frame) << camera->last_error().text();
  }
}

// As the capture thread waits: somebody pulls the plug while it is inside the driver.
TYPED_TEST_P(CameraContract, UnpluggingEndsAWaitThatHasBegun) {
  if constexpr (!TypeParam::kLive) {
    GTEST_SKIP() << "nothing that could be unplugged";
  } else {
    const auto camera = this->open(this->rig_.address());
    ASSERT_TRUE(camera);
    FramePool pool(camera->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame);
    this->rig_.pause();
    ASSERT_EQ(this->grab_until(*camera, frame, Grab::timeout), Grab::timeout);
    std::atomic<bool> inside = false;
    Grab grab = Grab::timeout;
    std::thread reader([&] {
      inside = true;
      grab = camera->grab(frame, this->kPatient);
    });
    while (!inside) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    this->rig_.unplug();
    reader.join();
    EXPECT_EQ(grab, Grab::gone);
    this->expect_seen_to_go(*camera);
    this->rig_.plug();
    EXPECT_EQ(this->grab_until(*camera, frame, Grab::frame), Grab::frame) << camera->last_error().text();
  }
}

// A live camera's times are the device's stamps and the offset that it was given; a recording has its own.
TYPED_TEST_P(CameraContract, TheClockOffsetIsInTheTimes) {
  constexpr std::chrono::hours kOffset(1000);
  FrameTime times[2];
  for (const int shifted : {0, 1}) {
    auto camera = this->rig_.open(this->rig_.address(), shifted * kOffset);
    ASSERT_TRUE(camera.ok()) << camera.error().text();
    FramePool pool((*camera)->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ((*camera)->grab(frame, this->kPatient), Grab::frame) << (*camera)->last_error().text();
    EXPECT_LE(std::chrono::abs(frame.depth_time - frame.colour_time), std::chrono::milliseconds(40)) << "both";
    times[shifted] = frame.colour_time;
  }
  const auto expected = TypeParam::kLive ? kOffset : std::chrono::hours(0);
  EXPECT_LT(std::chrono::abs(times[1] - times[0] - expected), std::chrono::minutes(5));
}

TYPED_TEST_P(CameraContract, ClosesWhileItStreamsAndFramesOutliveIt) {
  for (int round = 0; round < 3; ++round) {
    auto camera = this->open(this->rig_.address());
    ASSERT_TRUE(camera);
    FramePool pool(camera->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ(camera->grab(frame, this->kPatient), Grab::frame) << camera->last_error().text();
    camera.reset();
    EXPECT_TRUE(this->has_content(frame.view()));
  }
}

TYPED_TEST_P(CameraContract, TwoCamerasAtOnce) {
  const auto one = this->open(this->rig_.address()), other = this->open(this->rig_.other());
  ASSERT_TRUE(one && other);
  FramePool pool(one->intrinsics(), 1), other_pool(other->intrinsics(), 1);
  Frame frame = pool.acquire(), other_frame = other_pool.acquire();
  for (std::uint64_t i = 0; i < 5; ++i) {
    ASSERT_EQ(one->grab(frame, this->kPatient), Grab::frame) << one->last_error().text();
    ASSERT_EQ(other->grab(other_frame, this->kPatient), Grab::frame) << other->last_error().text();
    EXPECT_EQ(frame.index, i);
    EXPECT_EQ(other_frame.index, i);
    EXPECT_FALSE(std::ranges::equal(frame.view().depth, other_frame.view().depth)) << "each sees its own";
  }
}

REGISTER_TYPED_TEST_SUITE_P(CameraContract, OpensAndSaysWhatItIs, WrongAddressesAreErrorsThatSayWhy,
                            FramesAreWholeAndTheirTimesIncrease, EveryFormatGivesWholeFramesInMetres,
                            NoFrameIsLostWhenAllAreTaken, WaitingEndsWithTheTimeout,
                            AnUnpluggedCameraIsGoneAndComesBack, UnpluggingEndsAWaitThatHasBegun,
                            TheClockOffsetIsInTheTimes, ClosesWhileItStreamsAndFramesOutliveIt, TwoCamerasAtOnce);

}  // namespace onemap::hal
