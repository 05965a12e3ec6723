// Fusing fr1_xyz (every 5th frame, ground-truth poses) at 2 cm; extracting it; its submaps' size; a team's atlas.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hal/backends/replay.hpp"
#include "mapping/local/surface.hpp"
#include "mapping/team/atlas.hpp"
#include "support/tum_recording.hpp"

namespace {

using namespace onemap;
using namespace onemap::mapping;

struct PosedFrame {
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
  Pose T_world_camera;
};

struct Recording {
  hal::Intrinsics intrinsics;
  std::vector<PosedFrame> frames;
};

// The truth at the depth image nearest in time to the frame.
bool truth_at(const test::TumRecording& truth, double time_s, Pose& out) {
  const auto& depths = truth.depths();
  const auto nearest = std::min_element(depths.begin(), depths.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.time_s - time_s) < std::abs(b.time_s - time_s);
  });
  return truth.truth(static_cast<std::size_t>(nearest - depths.begin()), out);
}

Recording load() {
  Recording out;
  const std::string folder = std::string(ONEMAP_SHARED_DIR) + "/data/fr1_xyz";
  const test::TumRecording truth(folder);
  const hal::Backend table[] = {{"replay", "", hal::open_replay}};
  auto camera = hal::open_camera(table, "replay:" + folder);
  if (!camera.ok() || !truth.ok()) return out;
  out.intrinsics = (*camera)->intrinsics();
  hal::FramePool pool(out.intrinsics, 1);
  for (int i = 0;; ++i) {
    hal::Frame frame = pool.acquire();
    const hal::Grab grab = (*camera)->grab(frame, std::chrono::milliseconds(1000));
    if (grab == hal::Grab::end) break;
    Pose pose;
    if (grab != hal::Grab::frame || i % 5 != 0 || !truth_at(truth, to_seconds(frame.colour_time), pose)) continue;
    out.frames.push_back(
        {{frame.rgb().begin(), frame.rgb().end()}, {frame.depth().begin(), frame.depth().end()}, pose});
  }
  return out;
}

const Recording& recording() {
  static const Recording frames = load();
  return frames;
}

void fuse(VoxelMap& map, const RayTable& rays, const PosedFrame& frame) {
  map.integrate({{}, {}, 0, &recording().intrinsics, frame.rgb, frame.depth}, rays, frame.T_world_camera);
}

const VoxelMap& fused() {
  static const VoxelMap map = [] {
    VoxelMap out{VoxelMapConfig{}};
    const RayTable rays(recording().intrinsics);
    for (const PosedFrame& frame : recording().frames) fuse(out, rays, frame);
    return out;
  }();
  return map;
}

std::vector<SubmapRecord> submaps_of(const VoxelMap& map) {
  std::vector<BlockKey> keys;
  map.for_each_sorted([&](const BlockView& block) { keys.push_back(block.key); });
  std::vector<SubmapRecord> out;
  for (std::size_t i = 0; i < keys.size(); i += 128)
    out.push_back(make_submap(map, std::span(keys).subspan(i, std::min<std::size_t>(128, keys.size() - i))));
  return out;
}

// Loads and fuses before anything is timed.
bool missing(benchmark::State& state) {
  if (!recording().frames.empty() && fused().used() > 0) return false;
  state.SkipWithError("needs data/fr1_xyz in ONEMAP_SHARED_DIR");
  return true;
}

void integrate(benchmark::State& state) {
  if (missing(state)) return;
  VoxelMap map{VoxelMapConfig{}};
  const RayTable rays(recording().intrinsics);
  std::size_t i = 0;
  for (auto _ : state) fuse(map, rays, recording().frames[i++ % recording().frames.size()]);
  state.counters["blocks"] = static_cast<double>(map.used());
  state.counters["capacity"] = static_cast<double>(map.capacity());
}
BENCHMARK(integrate)->Unit(benchmark::kMillisecond)->Iterations(316);

void mesh(benchmark::State& state) {
  if (missing(state)) return;
  TriangleMesh out;
  for (auto _ : state) out = extract_mesh(fused());
  state.counters["triangles"] = static_cast<double>(out.triangles.size());
}
BENCHMARK(mesh)->Unit(benchmark::kMillisecond);

void submap_codec(benchmark::State& state) {
  if (missing(state)) return;
  double bytes = 0, blocks = 0, observed = 0;
  for (auto _ : state) {
    bytes = blocks = observed = 0;
    for (const SubmapRecord& record : submaps_of(fused())) {
      const auto body = encode(record);
      benchmark::DoNotOptimize(decode_submap(body));
      bytes += static_cast<double>(body.size());
      blocks += static_cast<double>(record.blocks.size());
      for (const SubmapBlock& block : record.blocks)
        observed += static_cast<double>(
            std::count_if(block.voxels.begin(), block.voxels.end(), [](const SubmapVoxel& v) { return v.weight > 0; }));
    }
  }
  state.counters["bytes_per_block"] = bytes / blocks;
  state.counters["bytes_per_observed_voxel"] = bytes / observed;
  // A surface point is a vertex of the mesh: a zero crossing between two voxels.
  state.counters["bytes_per_surface_point"] = bytes / static_cast<double>(extract_mesh(fused()).vertices.size());
}
BENCHMARK(submap_codec)->Unit(benchmark::kMillisecond);

void atlas_of_four(benchmark::State& state) {
  if (missing(state)) return;
  const auto records = submaps_of(fused());
  std::vector<Atlas::Submap> submaps;
  for (std::size_t i = 0; i < records.size(); ++i) submaps.push_back({static_cast<std::uint32_t>(i), &records[i]});
  std::vector<QuantizedPose> robots;
  for (int r = 1; r <= 4; ++r) {
    Vector6d motion;
    motion << 0.1 * r, -0.2 * r, 0.05 * r, 0.9 * r, 0.3 * r, 0.1;
    robots.push_back(quantize(small_motion(motion)));
  }
  Atlas atlas({});
  for (auto _ : state) {
    atlas.clear();
    for (const QuantizedPose& T_map_robot : robots) atlas.add({T_map_robot, submaps});
  }
  state.counters["source_blocks"] = static_cast<double>(atlas.counters().blocks);
  state.counters["global_blocks"] = static_cast<double>(atlas.map().used());
  state.counters["global_points"] = static_cast<double>(extract_mesh(atlas.map(), 1).vertices.size());
}
BENCHMARK(atlas_of_four)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
