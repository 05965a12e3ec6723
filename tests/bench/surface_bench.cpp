// The surface of a simulated room from frames with sensor noise under their true poses: ours, and of a peer that was
// given the same frames, judged by the room's formulas.
//   bench_surface ADDRESS EVERY FOLDER dump     writes the frames for the peer: intrinsics.txt poses.txt depth.bin
//   rgb.bin bench_surface ADDRESS EVERY FOLDER judge    fuses, and judges itself and each PLY of the folder
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "mapping/local/surface.hpp"
#include "mapping/local/voxel_map.hpp"
#include "options.hpp"
#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "support/true_surface.hpp"

namespace {

using namespace onemap;
using namespace onemap::mapping;
namespace fs = std::filesystem;

constexpr double kLeast_m = 0.5;  // nearer, the simulated camera has no reading

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

template <class T>
void append(std::ofstream& to, const std::vector<T>& values) {
  to.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
}

void dump(const test::RoomFrames& seen, const fs::path& folder) {
  const hal::Intrinsics& k = seen.intrinsics;
  std::ofstream(folder / "intrinsics.txt") << fmt::format("{} {} {} {} {} {} {} {}\n", k.width, k.height, k.fx, k.fy,
                                                          k.cx, k.cy, k.depth_scale, VoxelMapConfig{}.max_depth_m);
  std::ofstream poses(folder / "poses.txt"), depth(folder / "depth.bin"), rgb(folder / "rgb.bin");
  for (const test::RoomFrame& frame : seen.frames) {
    const Pose T = frame.T_world_camera;
    for (int i = 0; i < 3; ++i)
      poses << fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", T.R(i, 0), T.R(i, 1), T.R(i, 2), T.t[i]);
    poses << "0 0 0 1\n";
    append(depth, frame.depth);
    append(rgb, frame.rgb);
  }
}

void print(const std::string& name, const test::SurfaceScore& score, const std::string& time) {
  fmt::print("{:24} {:8.2f} {:8.2f} {:12.2f} {:>10} {:>9}\n", name, 1e3 * score.rms_m, 100 * score.off,
             100 * score.completeness, score.triangles, time);
}

struct Fused {
  TriangleMesh mesh;
  double ms_per_frame = 0;
};

Fused fuse(const test::RoomFrames& seen, const VoxelMapConfig& config) {
  VoxelMap map(config);
  const RayTable rays(seen.intrinsics);
  std::vector<double> ms;
  for (const test::RoomFrame& frame : seen.frames) {
    const double before = cpu_ms();
    map.integrate({{}, {}, 0, &seen.intrinsics, frame.rgb, frame.depth}, rays, frame.T_world_camera);
    ms.push_back(cpu_ms() - before);
  }
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  if (map.counters().blocks_refused > 0) fmt::print("the map was full\n");
  fmt::print("{} blocks\n", map.used());
  return {extract_mesh(map), ms[ms.size() / 2]};
}

int judge(const std::string& address, std::size_t every, const fs::path& folder) {
  const auto options = hal::simulated::parse_options(*hal::parse_camera_address(address));
  const auto scene = hal::simulated::build_scene(options->scene, options->seed);
  VoxelMapConfig config;
  config.budget_bytes = 256u << 20;
  const auto visible = test::visible_surface(address, every, kLeast_m, static_cast<double>(config.max_depth_m));
  const auto read = test::visible_surface(address, every, kLeast_m, static_cast<double>(config.max_depth_m), true);
  fmt::print("{}: {} visible places, of which {:.2f} % have a place within 2 cm that any frame had a reading of\n",
             address, visible.size(), 100 * test::share_within(visible, read));
  fmt::print("{:24} {:>8} {:>8} {:>12} {:>10} {:>9}\n", "", "rms mm", "off %", "complete %", "triangles", "ms/frame");
  const Fused ours = fuse(test::room_frames(address, every), config);
  print("onemap", test::judge(ours.mesh, scene, visible), fmt::format("{:.2f}", ours.ms_per_frame));
  if (const auto wrote = render::write_ply(folder / "onemap.ply", ours.mesh); !wrote.ok()) return 1;
  std::vector<fs::path> peers;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".ply" && entry.path().stem() != "onemap") peers.push_back(entry.path());
  std::sort(peers.begin(), peers.end());
  for (const fs::path& peer : peers) {
    const auto mesh = render::read_ply(peer);
    if (!mesh.ok()) return fmt::print(stderr, "{}\n", mesh.error().text()), 1;
    std::string time = "?";
    std::ifstream(fs::path(peer).replace_extension(".ms")) >> time;
    print(peer.stem(), test::judge(*mesh, scene, visible), time);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 5 ? argv[4] : "";
  if (what != "dump" && what != "judge")
    return fmt::print(stderr, "bench_surface ADDRESS EVERY FOLDER dump|judge\n"), 2;
  const std::string address = argv[1];
  const auto every = static_cast<std::size_t>(std::max(1, std::atoi(argv[2])));
  if (what == "judge") return judge(address, every, argv[3]);
  dump(test::room_frames(address, every), argv[3]);
  return 0;
}
