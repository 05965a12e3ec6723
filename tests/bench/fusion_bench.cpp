// What fusing a robot's submaps into a map costs, in its parts: decoding the records, moving and resampling the blocks,
// and the digest of the map. The map's frame is turned against the robot's, as another robot's is. Processor time for
// 1000 blocks, the least of several rounds.
//   bench_fusion [FRAMES [ROUNDS]]      default: 150 frames, 10 rounds
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <map>

#include "support/team_robots.hpp"

namespace {

using namespace onemap;
using namespace onemap::mapping;

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

// What is timed in each round, and the least of it.
struct Stage {
  const char* name;
  double least_ms = 1e300;
  std::size_t blocks = 0;

  template <class Fn>
  void run(Fn&& fn) {
    const double before = cpu_ms();
    fn();
    least_ms = std::min(least_ms, cpu_ms() - before);
  }
  void print() const {
    fmt::print("{:10} {:6} blocks, {:7.2f} ms a thousand\n", name, blocks,
               1000 * least_ms / static_cast<double>(blocks));
  }
};

// A robot's submaps as they came, and where the robot itself believes each anchor.
struct Log {
  std::vector<RecordPtr> submaps;
  std::map<std::uint32_t, QuantizedPose> anchors;
};

Pose T_map_robot() {
  Vector6d turn;
  turn << 0.3, -0.2, 0.5, 1, 2, 3;
  return small_motion(turn);
}

Log read(const std::vector<RecordPtr>& records) {
  Log out;
  for (const RecordPtr& record : records) {
    if (record->kind == static_cast<std::uint16_t>(RecordKind::submap)) out.submaps.push_back(record);
    if (record->kind != static_cast<std::uint16_t>(RecordKind::keyframe)) continue;
    const auto keyframe = decode_keyframe(record->body);
    out.anchors[keyframe->index] = quantize(T_map_robot() * from_quantized(keyframe->T_robot_keyframe));
  }
  return out;
}

using Decoded = std::map<std::uint32_t, LatestSubmaps>;

void decode(const Log& log, Decoded& into, std::size_t& blocks) {
  for (auto record = log.submaps.rbegin(); record != log.submaps.rend(); ++record) {
    auto submap = decode_submap((*record)->body);
    blocks += submap->blocks.size();
    into.try_emplace(submap->anchor_keyframe, SIZE_MAX / 2)
        .first->second.add_older((*record)->id.seq, std::move(*submap));
  }
}

void measure(const Log& log, int rounds) {
  Stage decoding{"decode"}, resampling{"resample"}, digesting{"digest"};
  AtlasConfig config;
  config.map.budget_bytes = 256u << 20;
  Atlas atlas(config);
  std::uint64_t digest = 0;
  for (int i = 0; i < rounds; ++i) {
    Decoded decoded;
    decoding.blocks = 0;
    decoding.run([&] { decode(log, decoded, decoding.blocks); });
    atlas.clear();
    resampling.run([&] {
      for (const auto& [anchor, submaps] : decoded) atlas.add({log.anchors.at(anchor), submaps.submaps()});
    });
    digesting.run([&] { digest = atlas.map().digest(); });
  }
  resampling.blocks = atlas.counters().blocks;
  digesting.blocks = atlas.map().used();
  for (const Stage* stage : {&decoding, &resampling, &digesting}) stage->print();
  fmt::print("{} records, {} anchors; digest {:016x}\n", log.submaps.size(), log.anchors.size(), digest);
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 150, rounds = argc > 2 ? std::atoi(argv[2]) : 10;
  const auto robot = test::explore("robot1", fmt::format("simulated:house?robot=1&robots=5&frames={}&seed=5", frames));
  measure(read(robot.written()), rounds);
}
