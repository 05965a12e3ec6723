#include "hal/backends/simulated.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "hal/frame_pool.hpp"

// The simulated camera against what must be true of any camera in a room: the same bytes every time, depth and colour
// that agree between frames under the true poses, noise of the stated size. Nothing here looks inside the backend.
namespace onemap::hal {
namespace {

struct SeenPicture {
  FrameTime time{}, depth_time{};
  std::uint64_t index = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

CameraAddress address_of(const std::string& text) {
  auto address = parse_camera_address(text);
  EXPECT_TRUE(address.ok());
  return *address;
}

std::unique_ptr<DepthCamera> open(const std::string& text) {
  auto camera = open_simulated(address_of(text));
  EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().text());
  return std::move(camera).value();
}

// The frames with the given numbers, in rising order.
std::vector<SeenPicture> take(DepthCamera& camera, const std::set<std::uint64_t>& wanted) {
  FramePool pool(camera.intrinsics(), 1);
  std::vector<SeenPicture> out;
  Frame frame = pool.acquire();
  for (std::uint64_t i = 0; i <= *wanted.rbegin(); ++i) {
    EXPECT_EQ(camera.grab(frame, std::chrono::milliseconds(0)), Grab::frame);
    if (!wanted.contains(i)) continue;
    out.push_back({frame.colour_time, frame.depth_time, frame.index, {}, {}});
    out.back().rgb.assign(frame.rgb().begin(), frame.rgb().end());
    out.back().depth.assign(frame.depth().begin(), frame.depth().end());
  }
  return out;
}

std::vector<SeenPicture> take(const std::string& text, const std::set<std::uint64_t>& wanted) {
  return take(*open(text), wanted);
}

TEST(Simulated, SameAddressGivesSameBytes) {
  for (const std::string scene :
       {"living-room", "office", "storage", "empty-hall", "corridor", "house", "ring", "blank-walls"}) {
    const std::string text = "simulated:" + scene + "?robot=2&width=160&height=120&seed=4";
    const auto a = take(text, {0, 3}), b = take(text, {0, 3});
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(a[i].rgb, b[i].rgb) << scene;
      EXPECT_EQ(a[i].depth, b[i].depth) << scene;
    }
    EXPECT_NE(a[0].rgb, a[1].rgb) << scene;
  }
}

TEST(Simulated, EndsAfterTheGivenFramesWithRisingTimes) {
  auto camera = open("simulated:empty-hall?frames=5&width=64&height=48&fps=25");
  EXPECT_EQ(camera->frames_expected(), 5u);
  const auto frames = take(*camera, {0, 1, 2, 3, 4});
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
    const auto camera = open_simulated(address_of(text));
    ASSERT_FALSE(camera.ok()) << text;
    EXPECT_NE(camera.error().text().find(reason), std::string::npos) << camera.error().text();
    EXPECT_NE(camera.error().text().find(text), std::string::npos) << camera.error().text();
    EXPECT_FALSE(simulated_truth(address_of(text)).ok()) << text;
  }
}

// A change of this number is a change of every simulated recording: of textures, furniture, walks or noise.
TEST(Simulated, PinnedBytes) {
  const SeenPicture p = take("simulated:living-room?robot=2&seed=1&width=320&height=240", {7}).front();
  std::uint64_t h = 1469598103934665603u;  // FNV-1a
  const auto add = [&](std::uint64_t byte) { h = (h ^ byte) * 1099511628211u; };
  for (const auto v : p.rgb) add(v);
  for (const auto v : p.depth) add(v & 255u), add(v >> 8);
  EXPECT_EQ(h, 0x6714a79124fa2ae8u) << std::hex << h;
}

using Vec = std::array<double, 3>;

// The geometry of one frame under its true pose, for 640x480 and its like: plain formulas, rotation by quaternion.
struct Seen {
  SeenPicture picture;
  SimulatedPose pose;
  Intrinsics k;

  static Vec turn(const std::array<double, 4>& q, const Vec& v) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return {(1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - z * w) * v[1] + 2 * (x * z + y * w) * v[2],
            2 * (x * y + z * w) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - x * w) * v[2],
            2 * (x * z - y * w) * v[0] + 2 * (y * z + x * w) * v[1] + (1 - 2 * (x * x + y * y)) * v[2]};
  }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(x);
  }
  double depth_m(int x, int y) const { return picture.depth[at(x, y)] / k.depth_scale; }
  int grey(int x, int y) const {
    const std::size_t i = 3 * at(x, y);
    return (picture.rgb[i] + picture.rgb[i + 1] + picture.rgb[i + 2]) / 3;
  }
  Vec world(int x, int y) const {
    const double z = depth_m(x, y);
    Vec p = turn(pose.q_world_camera_xyzw, {(x - k.cx) / k.fx * z, (y - k.cy) / k.fy * z, z});
    for (std::size_t i = 0; i < 3; ++i) p[i] += pose.t_world_camera_m[i];
    return p;
  }
  // Pixel column, row and depth of a world point; depth <= 0 when it is out of the picture.
  Vec project(Vec p) const {
    const auto& q = pose.q_world_camera_xyzw;
    for (std::size_t i = 0; i < 3; ++i) p[i] -= pose.t_world_camera_m[i];
    const Vec c = turn({-q[0], -q[1], -q[2], q[3]}, p);
    if (c[2] < 0.1) return {0, 0, -1};
    const Vec out{k.fx * c[0] / c[2] + k.cx, k.fy * c[1] / c[2] + k.cy, c[2]};
    const bool in = out[0] >= 0 && out[1] >= 0 && out[0] <= k.width - 1 && out[1] <= k.height - 1;
    return in ? out : Vec{0, 0, -1};
  }
};

std::vector<Seen> see(const std::string& text, const std::set<std::uint64_t>& wanted) {
  auto camera = open(text);
  const auto truth = simulated_truth(address_of(text));
  EXPECT_TRUE(truth.ok());
  std::vector<Seen> out;
  for (SeenPicture& picture : take(*camera, wanted)) {
    const std::size_t i = picture.index;
    EXPECT_EQ(picture.time, (*truth)[i].time);
    out.push_back({std::move(picture), (*truth)[i], camera->intrinsics()});
  }
  return out;
}

// What becomes of a's pixels in b.
struct Agreement {
  int sampled = 0, in_view = 0, same = 0, hidden = 0, beyond = 0;
  std::vector<int> grey_differences;
};
Agreement compare(const Seen& a, const Seen& b) {
  Agreement out;
  for (int y = 3; y < a.k.height; y += 6) {
    for (int x = 3; x < a.k.width; x += 6) {
      if (a.depth_m(x, y) <= 0) continue;
      ++out.sampled;
      const Vec p = b.project(a.world(x, y));
      if (p[2] <= 0) continue;
      const int u = static_cast<int>(std::lround(p[0])), v = static_cast<int>(std::lround(p[1]));
      const double there = b.depth_m(u, v), tolerance = 0.01 * p[2];
      if (there <= 0) continue;
      ++out.in_view;
      if (there < p[2] - tolerance) {
        ++out.hidden;
      } else if (there > p[2] + tolerance) {
        ++out.beyond;
      } else {
        ++out.same;
        out.grey_differences.push_back(std::abs(a.grey(x, y) - b.grey(u, v)));
      }
    }
  }
  return out;
}

TEST(Simulated, FramesAgreeUnderTheTruePoses) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall", "blank-walls"}) {
    const auto frames = see("simulated:" + scene + "?noise=none&seed=3", {0, 10, 25});
    for (const auto& [i, j] : {std::pair{0, 1}, {1, 0}, {0, 2}, {2, 1}}) {
      Agreement got = compare(frames[static_cast<std::size_t>(i)], frames[static_cast<std::size_t>(j)]);
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
  const auto exact = take(text + "&noise=none", wanted), noisy = take(text, wanted);
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
  const auto exact = take(text + "&noise=none", {0, 1}), noisy = take(text, {0, 1});
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
  const auto own = take(text, {3, 4}), late = take(text + "&depth_late_ms=40", {3});
  EXPECT_EQ(late[0].rgb, own[0].rgb);
  EXPECT_EQ(late[0].depth, own[1].depth);
  EXPECT_EQ(late[0].time, own[0].time);
  EXPECT_EQ(late[0].depth_time - late[0].time, std::chrono::milliseconds(40));
  EXPECT_EQ(own[0].depth_time, own[0].time);
}

TEST(Simulated, ACameraMayBeCarriedElsewhere) {
  const std::string text = "simulated:house?width=160&height=120&noise=none&robots=3&robot=";
  const auto own = take(text + "1", {3}), next = take(text + "2", {4}), carried = take(text + "1&carried_at=4", {3, 4});
  EXPECT_EQ(carried[0].depth, own[0].depth);
  EXPECT_EQ(carried[1].depth, next[0].depth);
  EXPECT_LT(carried[0].time, carried[1].time);
}

TEST(Simulated, DepthKeepsItsRange) {
  const auto exact = take("simulated:empty-hall?noise=none", {0}).front();
  const auto noisy = take("simulated:empty-hall?near=1.2&far=1.9", {0}).front();
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
      const auto frames = see(text, all);
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
    for (const SeenPicture& p : take("simulated:" + scene + "?width=320&height=240&frames=620", wanted))
      sum += share_with_structure(p, 320, 240) / 7;
    return sum;
  };
  EXPECT_LT(mean("blank-walls"), 0.12);
  EXPECT_GT(mean("living-room"), 0.6);
}

double overlap(const Seen& a, const Seen& b) {
  const Agreement got = compare(a, b);
  return static_cast<double>(got.same) / got.sampled;
}

TEST(Simulated, RobotsStartApartAndSeeTheSameThings) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall"}) {
    std::vector<std::vector<Seen>> robots;
    for (int robot = 1; robot <= 3; ++robot)
      robots.push_back(
          see("simulated:" + scene + "?noise=none&fps=1&robot=" + std::to_string(robot), {0, 1, 2, 3, 4, 5}));
    for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {0, 2}}) {
      double best = 0;
      for (const Seen& x : robots[a])
        for (const Seen& y : robots[b]) best = std::max(best, overlap(x, y));
      EXPECT_GT(best, 0.6) << scene << " robots " << a + 1 << " and " << b + 1;
    }
    const double first = overlap(robots[0][0], robots[1][0]);
    EXPECT_GT(first, 0.15) << scene;
    EXPECT_LT(first, 0.85) << scene;
  }
}

// Three robots in the house: neighbours see the same at their passage, the outer two share little, and each is
// in free space and turns no faster than a hand.
TEST(Simulated, RobotsOfTheHouseMeetAtTwoPlaces) {
  std::vector<std::vector<Seen>> robots;
  std::set<std::uint64_t> all;
  for (std::uint64_t i = 0; i < 108; ++i) all.insert(i);
  for (int robot = 1; robot <= 3; ++robot)
    robots.push_back(
        see("simulated:house?noise=none&fps=6&width=160&height=120&frames=108&robot=" + std::to_string(robot), all));
  for (const auto& frames : robots)
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_GT(*std::ranges::min_element(frames[i].picture.depth), 0.35 * 5000) << i;
      if (i == 0) continue;
      double cosine = 0;
      for (std::size_t c = 0; c < 4; ++c)
        cosine += frames[i].pose.q_world_camera_xyzw[c] * frames[i - 1].pose.q_world_camera_xyzw[c];
      EXPECT_LT(2 * std::acos(std::min(1.0, std::abs(cosine))) * 6 * 57.2958, 60) << i;
    }
  double all_of_last = 0;  // overlap over all pairs of frames
  const auto best = [&](std::size_t a, std::size_t b) {
    double most = 0;
    all_of_last = 0;
    for (std::size_t i = 0; i < 108; i += 4)
      for (std::size_t j = 0; j < 108; j += 4) {
        const double here = overlap(robots[a][i], robots[b][j]);
        most = std::max(most, here);
        all_of_last += here / (27 * 27);
      }
    return most;
  };
  EXPECT_GT(best(0, 1), 0.5);
  EXPECT_GT(best(1, 2), 0.5);
  best(0, 2);
  EXPECT_LT(all_of_last, 0.1) << "each has a room of its own";
}

// A square piece of a picture, grey, mean 0 and length 1; `contrast` is its standard deviation before.
constexpr int kSide = 21, kPixels = kSide * kSide, kViewWidth = 320, kViewHeight = 240;
struct Piece {
  std::array<float, kPixels> values{};
  float contrast = 0;

  Piece(const SeenPicture& p, int x, int y) {
    float mean = 0, squares = 0;
    for (int i = 0; i < kPixels; ++i) {
      const auto at = 3 * static_cast<std::size_t>((y + i / kSide) * kViewWidth + x + i % kSide);
      values[static_cast<std::size_t>(i)] = static_cast<float>(p.rgb[at] + p.rgb[at + 1] + p.rgb[at + 2]) / 3;
    }
    for (const float v : values) mean += v / kPixels;
    for (const float v : values) squares += (v - mean) * (v - mean);
    contrast = std::sqrt(squares / kPixels);
    const float scale = 1 / std::sqrt(squares + 1e-3f);
    for (float& v : values) v = (v - mean) * scale;
  }

  // Gradients in more than one direction (a straight edge looks like every other): the structure tensor's smaller
  // eigenvalue is not small beside the larger.
  bool corner() const {
    float xx = 0, xy = 0, yy = 0;
    for (int y = 1; y + 1 < kSide; ++y) {
      for (int x = 1; x + 1 < kSide; ++x) {
        const float* v = values.data() + y * kSide + x;
        const float dx = v[1] - v[-1], dy = v[kSide] - v[-kSide];
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
      }
    }
    const float spread = std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy);
    return contrast > 12 && xx + yy - spread > 0.4f * (xx + yy + spread);
  }
};

// The share of a's pieces with structure that are found anywhere in b with a correlation over 0.9: an independent
// stand-in for feature matching.
double likeness(const SeenPicture& a, const SeenPicture& b) {
  std::vector<Piece> wanted;
  for (int y = 20; y < kViewHeight - 40; y += 24)
    for (int x = 20; x < kViewWidth - 40; x += 24)
      if (const Piece piece(a, x, y); piece.corner()) wanted.push_back(piece);
  EXPECT_GT(wanted.size(), 15u);
  std::vector<float> best(wanted.size(), -1.0f);
  for (int y = 0; y + kSide <= kViewHeight; ++y) {
    for (int x = 0; x + kSide <= kViewWidth; ++x) {
      const Piece here(b, x, y);
      for (std::size_t n = 0; n < wanted.size(); ++n) {
        float sum = 0;
        for (std::size_t i = 0; i < kPixels; ++i) sum += wanted[n].values[i] * here.values[i];
        best[n] = std::max(best[n], sum);
      }
    }
  }
  return static_cast<double>(std::ranges::count_if(best, [](float v) { return v > 0.9f; })) /
         static_cast<double>(best.size());
}

TEST(Simulated, PlacesWithoutOverlapDoNotLookAlike) {
  const std::string size = "&width=320&height=240";
  const auto room = take("simulated:living-room?robot=1" + size, {0, 10});
  const auto other = take("simulated:storage?robot=1" + size, {40});
  const auto seed = take("simulated:living-room?robot=1&seed=9" + size, {0});
  EXPECT_GT(likeness(room[0], room[1]), 0.5);
  EXPECT_LT(likeness(room[0], other[0]), 0.1);
  EXPECT_LT(likeness(room[0], seed[0]), 0.1);
}

}  // namespace
}  // namespace onemap::hal
