#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "../../hal/backends/simulated/src/caster.hpp"
#include "../../hal/backends/simulated/src/rooms.hpp"
#include "../../hal/backends/simulated/src/sensor.hpp"
#include "../../hal/backends/simulated/src/walk.hpp"
#include "hal/backends/simulated.hpp"

// The row-wise caster against a plain one: every pixel's ray against every shape, by the textbook.
namespace onemap::hal::simulated {
namespace {

// Depth along z of the nearest hit on a patch; rays have z = 1 in the camera, so that the ray's parameter is the depth.
std::optional<double> hit(const Patch& p, Vec3 from, Vec3 ray) {
  const Vec3 normal = cross(p.axis_u, p.axis_v);
  const double towards = dot(normal, ray);
  if (towards >= 0) return {};
  const double z = dot(normal, p.origin - from) / towards;
  const Vec3 at = from + z * ray - p.origin;
  const double u = dot(at, p.axis_u), v = dot(at, p.axis_v);
  if (z < 0.05 || u < 0 || v < 0 || u > p.size_u || v > p.size_v) return {};
  const double r = p.size_u / 2;
  if (p.round && (u - r) * (u - r) + (v - r) * (v - r) > r * r) return {};
  return z;
}

std::optional<double> hit(const Curved& c, Vec3 from, Vec3 ray) {
  const Vec3 o = from - c.base;
  const bool tube = c.height > 0;
  const double flat = tube ? 0 : 1;  // a ball's quadratic has the vertical terms too
  const double a = ray.x * ray.x + ray.y * ray.y + flat * ray.z * ray.z;
  const double b = o.x * ray.x + o.y * ray.y + flat * o.z * ray.z;
  const double q = o.x * o.x + o.y * o.y + flat * o.z * o.z - c.radius * c.radius;
  const double root2 = b * b - a * q;
  if (root2 < 0) return {};
  const double z = (-b - std::sqrt(root2)) / a, height = o.z + z * ray.z;
  if (z < 0.05 || (tube && (height < 0 || height > c.height))) return {};
  return z;
}

double plain_depth(const Scene& scene, Vec3 from, Vec3 ray) {
  double best = 1e9;
  for (const Patch& p : scene.patches) best = std::min(best, hit(p, from, ray).value_or(best));
  for (const Curved& c : scene.curved) best = std::min(best, hit(c, from, ray).value_or(best));
  return best;
}

TEST(SimulatedCaster, DepthIsTheNearestHitOfAPlainCaster) {
  Options options;
  options.width = 160;
  options.height = 120;
  const Intrinsics k = options.intrinsics();
  for (const SceneName name :
       {SceneName::living_room, SceneName::office, SceneName::storage, SceneName::empty_hall, SceneName::corridor}) {
    const Scene scene = build_scene(name, 5);
    Caster caster(scene, k);
    Row row(k.width);
    std::size_t pixels = 0, off = 0;
    for (int robot = 1; robot <= 4; ++robot) {
      const CameraPose pose = pose_on_walk(walk_in(name, 5), robot, 4, 5, 2.0 * robot);
      caster.start(pose);
      for (int y = 0; y < k.height; ++y) {
        caster.cast(y, row);
        for (int x = 0; x < k.width; ++x) {
          const Vec3 ray = (x - k.cx) / k.fx * pose.right + (y - k.cy) / k.fy * pose.down + pose.forward;
          const double z = plain_depth(scene, pose.position, ray);
          ++pixels;
          if (std::abs(1 / static_cast<double>(row.inverse_depth[static_cast<std::size_t>(x)]) - z) > 2e-5 * z) ++off;
        }
      }
    }
    EXPECT_LE(off, pixels / 20000) << static_cast<int>(name);  // rays through an edge may fall to either side
  }
}

TEST(SimulatedCaster, FrameMadeAloneIsTheFrameOfTheStream) {
  const std::string text = "simulated:office?robot=3&seed=8&width=160&height=120";
  const CameraAddress address = *parse_camera_address(text);
  auto camera = open_simulated(address);
  ASSERT_TRUE(camera.ok());
  FramePool pool((*camera)->intrinsics(), 2);
  Frame streamed = pool.acquire(), alone = pool.acquire();
  for (int i = 0; i <= 6; ++i) ASSERT_EQ((*camera)->grab(streamed, std::chrono::milliseconds(0)), Grab::frame);

  const Options options = *parse_options(address);
  const Scene scene = build_scene(options.scene, options.seed);
  Caster caster(scene, options.intrinsics());
  Sensor sensor(options);
  Row row(options.width);
  caster.start(pose_on_walk(walk_in(options.scene, options.seed), 3, 3, 8, 6.0 / 30));
  for (int y = 0; y < options.height; ++y) {
    caster.cast(y, row);
    sensor.take(6, y, row, alone.rgb(), alone.depth());
  }
  EXPECT_TRUE(std::ranges::equal(streamed.rgb(), alone.rgb()));
  EXPECT_TRUE(std::ranges::equal(streamed.depth(), alone.depth()));
}

TEST(SimulatedCaster, SineIsTheSine) {
  for (int i = -4000; i <= 4000; ++i) {
    const double turns = i * 0.00137;
    EXPECT_NEAR(sin_turns(turns), std::sin(6.283185307179586 * turns), 1e-11);
    EXPECT_NEAR(cos_turns(turns), std::cos(6.283185307179586 * turns), 1e-11);
  }
}

TEST(SimulatedCaster, FarTexturesAreTheMeanOfNearOnes) {
  // A fine checkerboard averages to grey once its squares are smaller than a pixel, at any place: it does not flicker.
  std::vector<std::uint8_t> base(64 * 64);
  for (std::size_t i = 0; i < base.size(); ++i) base[i] = ((i / 64 + i) & 1) != 0 ? 200 : 100;
  const Texture texture(base, 64, 64, 0.01);
  for (int at = 1024; at < 64 * 256 - 1024; at += 777) {
    EXPECT_EQ(texture.sample(at, at, 256), 150);
    EXPECT_EQ(texture.sample(at, at, 700), 150);
  }
  EXPECT_EQ(texture.sample(5 * 256 + 128, 5 * 256 + 128, 0), 100);
  EXPECT_EQ(texture.sample(6 * 256 + 128, 5 * 256 + 128, 0), 200);
}

}  // namespace
}  // namespace onemap::hal::simulated
