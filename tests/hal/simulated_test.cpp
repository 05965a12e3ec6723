#include "hal/backends/simulated.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "seen_frames.hpp"

// The simulated camera against what must be true of any camera in a room: the same bytes every time, depth and colour
// that agree between frames under the true poses, noise of the stated size. Nothing here looks inside the backend.
namespace onemap::hal {
namespace {

using test::Agreement;
using test::Seen;
using test::SeenPicture;

TEST(Simulated, SameAddressGivesSameBytes) {
  for (const std::string scene :
       {"living-room", "office", "storage", "empty-hall", "corridor", "house", "ring", "blank-walls"}) {
    const std::string text = "simulated:" + scene + "?robot=2&width=160&height=120&seed=4";
    const auto a = test::take(text, {0, 3}), b = test::take(text, {0, 3});
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(a[i].rgb, b[i].rgb) << scene;
      EXPECT_EQ(a[i].depth, b[i].depth) << scene;
    }
    EXPECT_NE(a[0].rgb, a[1].rgb) << scene;
  }
}

TEST(Simulated, EndsAfterTheGivenFramesWithRisingTimes) {
  auto camera = test::open("simulated:empty-hall?frames=5&width=64&height=48&fps=25");
  EXPECT_EQ(camera->frames_expected(), 5u);
  const auto frames = test::take(*camera, {0, 1, 2, 3, 4});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, i);
    EXPECT_EQ(frames[i].time - frames[0].time, std::chrono::milliseconds(40 * i));
  }
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  EXPECT_EQ(camera->grab(frame, std::chrono::milliseconds(0)), Grab::end);
  EXPECT_EQ(camera->counters().frames, 5u);
  EXPECT_EQ(camera->frames_expected(), 0u);
}

TEST(Simulated, BadAddressesSayWhatIsValid) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"simulated:cellar", "living-room, office, storage, empty-hall, corridor, house, ring, blank-walls"},
      {"simulated:", "living-room"},
      {"simulated:office?robto=1", "known: robot=1..robots"},
      {"simulated:office?robot=0", "whole number from 1 to 3"},
      {"simulated:office?robot=4", "whole number from 1 to 3"},
      {"simulated:office?robot=two", "robot=two"},
      {"simulated:office?frames=10x", "frames=10x"},
      {"simulated:office?seed=-1", "seed=-1"},
      {"simulated:office?noise=some", "expected kinect or none"},
      {"simulated:office?near=2&far=1.5", "not beyond"},
      {"simulated:office?width=", "whole number from 64 to 1920"},
      {"simulated:office?fps=0", "from 1 to 120"},
      {"simulated:office?depth_late_ms=51", "from -50 to 50"},
  };
  for (const auto& [text, reason] : cases) {
    const auto camera = open_simulated(test::address_of(text));
    ASSERT_FALSE(camera.ok()) << text;
    EXPECT_NE(camera.error().text().find(reason), std::string::npos) << camera.error().text();
    EXPECT_NE(camera.error().text().find(text), std::string::npos) << camera.error().text();
    EXPECT_FALSE(simulated_truth(test::address_of(text)).ok()) << text;
  }
}

// A change of this number is a change of every simulated recording: of textures, furniture, walks or noise.
TEST(Simulated, PinnedBytes) {
  const SeenPicture p = test::take("simulated:living-room?robot=2&seed=1&width=320&height=240", {7}).front();
  std::uint64_t h = 1469598103934665603u;  // FNV-1a
  const auto add = [&](std::uint64_t byte) { h = (h ^ byte) * 1099511628211u; };
  for (const auto v : p.rgb) add(v);
  for (const auto v : p.depth) add(v & 255u), add(v >> 8);
  EXPECT_EQ(h, 0x6714a79124fa2ae8u) << std::hex << h;
}

TEST(Simulated, FramesAgreeUnderTheTruePoses) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall", "blank-walls"}) {
    const auto frames = test::see("simulated:" + scene + "?noise=none&seed=3", {0, 10, 25});
    for (const auto& [i, j] : {std::pair{0, 1}, {1, 0}, {0, 2}, {2, 1}}) {
      Agreement got = test::compare(frames[static_cast<std::size_t>(i)], frames[static_cast<std::size_t>(j)]);
      ASSERT_GT(got.in_view, 1000) << scene;
      EXPECT_GT(got.same, 0.88 * got.in_view) << scene;    // the rest: behind something nearer
      EXPECT_LT(got.beyond, 0.02 * got.in_view) << scene;  // nobody looks through a surface, but for edge pixels
      std::ranges::sort(got.grey_differences);
      EXPECT_LE(got.grey_differences[got.grey_differences.size() / 2], 4) << scene;
    }
  }
}

TEST(Simulated, KinectNoiseHasTheStatedSize) {
  const std::string text = "simulated:living-room?seed=2&frames=121";
  const std::set<std::uint64_t> wanted{0, 40, 80, 120};
  const auto exact = test::take(text + "&noise=none", wanted), noisy = test::take(text, wanted);
  double sum = 0, squares = 0;
  std::size_t count = 0, holes = 0, wild = 0;
  for (std::size_t f = 0; f < exact.size(); ++f) {
    for (std::size_t i = 0; i < exact[f].depth.size(); ++i) {
      const double z = exact[f].depth[i] / 5000.0, measured = noisy[f].depth[i] / 5000.0;
      if (z < 0.6 || z > 4.5) continue;
      if (measured == 0) {
        ++holes;
        continue;
      }
      // In steps of an eighth of a pixel: sigma 0.5, and the rounding's 1/sqrt(12).
      const double steps = (measured - z) * 8 * 0.075 * 580 / (z * z);
      if (std::abs(steps) > 3.5) ++wild;
      sum += steps;
      squares += steps * steps;
      ++count;
    }
  }
  const double n = static_cast<double>(count);
  EXPECT_NEAR(sum / n, 0, 0.03);
  EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(0.25 + 1.0 / 12), 0.03);
  EXPECT_LT(static_cast<double>(wild), 1e-4 * n);
  EXPECT_GT(static_cast<double>(holes), 0.002 * n);
  EXPECT_LT(static_cast<double>(holes), 0.10 * n);
  EXPECT_NE(noisy[0].rgb, exact[0].rgb);
}

TEST(Simulated, NoiseIsFreshInEveryFrameAndForEveryRobot) {
  // The same rows of two frames: the noise on the depth must not be correlated.
  const std::string text = "simulated:empty-hall?seed=2";
  const auto exact = test::take(text + "&noise=none", {0, 1}), noisy = test::take(text, {0, 1});
  double both = 0, first = 0, second = 0;
  for (std::size_t i = 0; i < exact[0].depth.size(); ++i) {
    if (noisy[0].depth[i] == 0 || noisy[1].depth[i] == 0) continue;
    const double a = noisy[0].depth[i] - exact[0].depth[i], b = noisy[1].depth[i] - exact[1].depth[i];
    both += a * b;
    first += a * a;
    second += b * b;
  }
  EXPECT_LT(std::abs(both) / std::sqrt(first * second), 0.1);
}

// Depth 40 ms late is the depth of the next frame, and colour is as it was.
TEST(Simulated, DepthMayBeLate) {
  const std::string text = "simulated:office?width=160&height=120&noise=none&fps=25";
  const auto own = test::take(text, {3, 4}), late = test::take(text + "&depth_late_ms=40", {3});
  EXPECT_EQ(late[0].rgb, own[0].rgb);
  EXPECT_EQ(late[0].depth, own[1].depth);
  EXPECT_EQ(late[0].time, own[0].time);
  EXPECT_EQ(late[0].depth_time - late[0].time, std::chrono::milliseconds(40));
  EXPECT_EQ(own[0].depth_time, own[0].time);
}

TEST(Simulated, ACameraMayBeCarriedElsewhere) {
  const std::string text = "simulated:house?width=160&height=120&noise=none&robots=3&robot=";
  const auto own = test::take(text + "1", {3}), next = test::take(text + "2", {4}),
             carried = test::take(text + "1&carried_at=4", {3, 4});
  EXPECT_EQ(carried[0].depth, own[0].depth);
  EXPECT_EQ(carried[1].depth, next[0].depth);
  EXPECT_LT(carried[0].time, carried[1].time);
}

TEST(Simulated, DepthKeepsItsRange) {
  const auto exact = test::take("simulated:empty-hall?noise=none", {0}).front();
  const auto noisy = test::take("simulated:empty-hall?near=1.2&far=1.9", {0}).front();
  std::size_t outside = 0, inside = 0;
  for (std::size_t i = 0; i < noisy.depth.size(); ++i) {
    const auto z = noisy.depth[i];
    EXPECT_TRUE(z == 0 || (z >= 6000 && z <= 9500)) << z;
    if (exact.depth[i] > 9800) ++outside;
    if (z > 0) ++inside;
  }
  EXPECT_GT(outside, 1000u);
  EXPECT_GT(inside, 1000u);
}

TEST(Simulated, WalksAreSmoothAndInFreeSpaceForAnySeed) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall", "corridor", "blank-walls"}) {
    for (int seed = 1; seed <= 3; ++seed) {
      const std::string text = "simulated:" + scene +
                               "?noise=none&width=64&height=48&fps=6&frames=140&robot=" + std::to_string(seed) +
                               "&seed=" + std::to_string(seed);
      std::set<std::uint64_t> all;
      for (std::uint64_t i = 0; i < 140; ++i) all.insert(i);
      const auto frames = test::see(text, all);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        std::vector<std::uint16_t> depth = frames[i].picture.depth;
        std::ranges::sort(depth);
        EXPECT_GT(depth.front(), 0.35 * 5000) << text << " frame " << i;
        EXPECT_GT(depth[depth.size() / 2], 0.7 * 5000) << text << " frame " << i;
        EXPECT_LT(depth[depth.size() / 2], 3.6 * 5000) << text << " frame " << i;
        if (i == 0) continue;
        double step2 = 0, cosine = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const double d = frames[i].pose.t_world_camera_m[c] - frames[i - 1].pose.t_world_camera_m[c];
          step2 += d * d;
        }
        for (std::size_t c = 0; c < 4; ++c)
          cosine += frames[i].pose.q_world_camera_xyzw[c] * frames[i - 1].pose.q_world_camera_xyzw[c];
        EXPECT_LT(std::sqrt(step2) * 6, 0.55) << text;
        EXPECT_LT(2 * std::acos(std::min(1.0, std::abs(cosine))) * 6 * 57.2958, 29) << text;
      }
    }
  }
}

// Share of a picture's 8 x 8 blocks whose brightness changes by more than the noise and the fading towards the edges.
double share_with_structure(const SeenPicture& p, int width, int height) {
  int blocks = 0, structured = 0;
  for (int y = 0; y + 8 <= height; y += 8)
    for (int x = 0; x + 8 <= width; x += 8) {
      int least = 765, most = 0;
      for (int i = 0; i < 64; ++i) {
        const auto at = 3 * static_cast<std::size_t>((y + i / 8) * width + x + i % 8);
        const int grey = p.rgb[at] + p.rgb[at + 1] + p.rgb[at + 2];
        least = std::min(least, grey);
        most = std::max(most, grey);
      }
      ++blocks;
      structured += most - least > 3 * 12;
    }
  return static_cast<double>(structured) / blocks;
}

// All the way round, at most a few in a hundred blocks of the bare room have structure; a furnished room is full of it.
TEST(Simulated, MostOfBlankWallsHasNoTexture) {
  const std::set<std::uint64_t> wanted{0, 100, 200, 300, 400, 500, 600};
  const auto mean = [&](const std::string& scene) {
    double sum = 0;
    for (const SeenPicture& p : test::take("simulated:" + scene + "?width=320&height=240&frames=620", wanted))
      sum += share_with_structure(p, 320, 240) / 7;
    return sum;
  };
  EXPECT_LT(mean("blank-walls"), 0.12);
  EXPECT_GT(mean("living-room"), 0.6);
}

}  // namespace
}  // namespace onemap::hal
