#pragma once
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"

// What a simulated camera delivers, and the geometry of it by plain formulas.
namespace onemap::hal::test {

struct SeenPicture {
  FrameTime time{}, depth_time{};
  std::uint64_t index = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

inline CameraAddress address_of(const std::string& text) {
  auto address = parse_camera_address(text);
  EXPECT_TRUE(address.ok());
  return *address;
}

inline std::unique_ptr<DepthCamera> open(const std::string& text) {
  auto camera = open_simulated(address_of(text));
  EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().text());
  return std::move(camera).value();
}

// The frames with the given numbers, in rising order.
inline std::vector<SeenPicture> take(DepthCamera& camera, const std::set<std::uint64_t>& wanted) {
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

inline std::vector<SeenPicture> take(const std::string& text, const std::set<std::uint64_t>& wanted) {
  return take(*open(text), wanted);
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

inline std::vector<Seen> see(const std::string& text, const std::set<std::uint64_t>& wanted) {
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
inline Agreement compare(const Seen& a, const Seen& b) {
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

}  // namespace onemap::hal::test
