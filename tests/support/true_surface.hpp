#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <vector>

#include "distance.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/mesh.hpp"
#include "rooms.hpp"

// How good a mesh of a simulated room is, judged by the room's formulas. Needs the simulated camera's own headers.
namespace onemap::test {

// A frame of a simulated camera and where it was in the room.
struct RoomFrame {
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
  mapping::Pose T_world_camera;
};
struct RoomFrames {
  hal::Intrinsics intrinsics;
  std::vector<RoomFrame> frames;
};

// Every `every`-th frame of the address.
inline RoomFrames room_frames(const std::string& text, std::size_t every) {
  const auto address = hal::parse_camera_address(text);
  auto camera = hal::open_simulated(*address);
  const auto truth = hal::simulated_truth(*address);
  RoomFrames out{(*camera)->intrinsics(), {}};
  hal::FramePool pool(out.intrinsics, 1);
  hal::Frame frame = pool.acquire();
  for (std::size_t i = 0; i < truth->size(); ++i) {
    if ((*camera)->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    if (i % every != 0) continue;
    const auto& t = (*truth)[i].t_world_camera_m;
    const auto& q = (*truth)[i].q_world_camera_xyzw;
    out.frames.push_back({{frame.rgb().begin(), frame.rgb().end()},
                          {frame.depth().begin(), frame.depth().end()},
                          {mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}), {t[0], t[1], t[2]}}});
  }
  return out;
}

// A set of points, by cells of a cube's grid: of each cell one point.
class PointSet {
 public:
  explicit PointSet(double cell_m) : cell_m_(cell_m) {}
  void add(const mapping::Vector3d& p) { points_.try_emplace(key(cell(p)), p); }
  // Whether a point lies within reach_m, which is at most four cells.
  bool near(const mapping::Vector3d& p, double reach_m) const {
    const auto at = cell(p);
    const auto reach = static_cast<std::int64_t>(std::ceil(reach_m / cell_m_));
    for (std::int64_t z = -reach; z <= reach; ++z)
      for (std::int64_t y = -reach; y <= reach; ++y)
        for (std::int64_t x = -reach; x <= reach; ++x) {
          const auto found = points_.find(key({at[0] + x, at[1] + y, at[2] + z}));
          if (found != points_.end() && (found->second - p).squaredNorm() <= reach_m * reach_m) return true;
        }
    return false;
  }
  std::size_t size() const { return points_.size(); }
  template <class Fn>
  void for_each(Fn&& fn) const {
    for (const auto& [key, point] : points_) fn(point);
  }

 private:
  std::array<std::int64_t, 3> cell(const mapping::Vector3d& p) const {
    std::array<std::int64_t, 3> out{};
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = static_cast<std::int64_t>(std::floor(p[static_cast<int>(i)] / cell_m_));
    return out;
  }
  static std::uint64_t key(const std::array<std::int64_t, 3>& c) {
    std::uint64_t out = 0;
    for (const std::int64_t v : c) out = out << 21 | static_cast<std::uint64_t>(v + (1 << 20));
    return out;
  }
  double cell_m_;
  std::unordered_map<std::uint64_t, mapping::Vector3d> points_;
};

// fn(point) on a grid of about step_m over every triangle.
template <class Fn>
void sample_triangles(const mapping::TriangleMesh& mesh, double step_m, Fn&& fn) {
  for (const auto& t : mesh.triangles) {
    const mapping::Vector3d a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                            c = mesh.vertices[t[2]].cast<double>();
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()}));
    const int n = std::clamp(static_cast<int>(std::ceil(longest / step_m)), 1, 64);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j)
        fn(mapping::Vector3d(a + (b - a) * ((i + 1.0 / 3) / n) + (c - a) * ((j + 1.0 / 3) / n)));
  }
}

// The places that the cameras of an address could have seen, a centimetre apart: what an exact camera measures there.
// had_reading: those of them alone of which the address's own camera had a reading, however wrong.
inline PointSet visible_surface(const std::string& address, std::size_t every, double least_m, double most_m,
                                bool had_reading = false) {
  const std::string exact = address + (address.find('?') == std::string::npos ? "?noise=none" : "&noise=none");
  const RoomFrames seen = room_frames(exact, every);
  const RoomFrames read = had_reading ? room_frames(address, every) : RoomFrames{seen.intrinsics, {}};
  const mapping::RayTable rays(seen.intrinsics);
  PointSet out(0.01);
  for (std::size_t n = 0; n < seen.frames.size(); ++n)
    for (int v = 0; v < seen.intrinsics.height; ++v)
      for (int u = 0; u < seen.intrinsics.width; ++u) {
        const auto i = static_cast<std::size_t>(v * seen.intrinsics.width + u);
        const double z = seen.frames[n].depth[i] / seen.intrinsics.depth_scale;
        if (z < least_m || z > most_m || (had_reading && read.frames[n].depth[i] == 0)) continue;
        const float* ray = rays.row(v) + 2 * u;
        out.add(seen.frames[n].T_world_camera *
                mapping::Vector3d(z * static_cast<double>(ray[0]), z * static_cast<double>(ray[1]), z));
      }
  return out;
}

// The share of these places that have one of those within 2 cm.
inline double share_within(const PointSet& places, const PointSet& of) {
  double found = 0;
  places.for_each([&](const mapping::Vector3d& p) { found += of.near(p, 0.02); });
  return found / static_cast<double>(std::max<std::size_t>(places.size(), 1));
}

struct SurfaceScore {
  double rms_m = 0;         // of the mesh's distance from the true surface, by area
  double off = 0;           // share of the mesh's area that is more than 3 cm from any surface
  double completeness = 0;  // share of the visible places that the mesh has within 2 cm
  std::size_t triangles = 0;
};

inline SurfaceScore judge(const mapping::TriangleMesh& mesh, const hal::simulated::Scene& scene,
                          const PointSet& visible) {
  SurfaceScore out;
  out.triangles = mesh.triangles.size();
  PointSet surface(0.01);
  sample_triangles(mesh, 0.005, [&](const mapping::Vector3d& p) { surface.add(p); });
  double sum = 0, far = 0;
  surface.for_each([&](const mapping::Vector3d& p) {
    const double d = hal::simulated::distance_to(scene, {p[0], p[1], p[2]});
    sum += d * d;
    far += d > 0.03;
  });
  const auto samples = static_cast<double>(std::max<std::size_t>(surface.size(), 1));
  out.rms_m = std::sqrt(sum / samples);
  out.off = far / samples;
  out.completeness = share_within(visible, surface);
  return out;
}

}  // namespace onemap::test
