#include "mapping/records/solution.hpp"

#include <xxhash.h>

#include <cmath>

#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxRobots = 1024, kMaxAnchors = 16384;
constexpr std::size_t kAnchorBytes = 4 + kPoseBytes, kRobotBytes = 16 + 8 + 2;

void put_robot(ByteWriter& out, const SolvedRobot& solved) {
  put(out, solved.chain);
  out.put(static_cast<std::uint16_t>(solved.anchors.size()));
  for (const PlacedAnchor& anchor : solved.anchors) {
    out.put(anchor.keyframe);
    put(out, anchor.T_map_anchor);
  }
}

SolvedRobot read_robot(FieldReader& in) {
  SolvedRobot out;
  out.chain = in.chain("robots.chain");
  out.anchors.resize(in.count<std::uint16_t>(kMaxAnchors, kAnchorBytes, "robots.anchors"));
  for (std::size_t i = 0; i < out.anchors.size(); ++i) {
    out.anchors[i].keyframe = in.get<std::uint32_t>("robots.anchors.keyframe");
    out.anchors[i].T_map_anchor = in.pose("robots.anchors.T_map_anchor");
    in.require(i == 0 || out.anchors[i - 1].keyframe < out.anchors[i].keyframe, "robots.anchors", "not sorted");
  }
  return out;
}

MapParameters read_parameters(FieldReader& in) {
  MapParameters out;
  out.voxel_um = in.get<std::int32_t>("map.voxel_um");
  in.require(out.voxel_um >= 1000 && out.voxel_um <= 1'000'000, "map.voxel_um", "not from 1 mm to 1 m");
  out.truncation_um = in.get<std::int32_t>("map.truncation_um");
  const std::int64_t band = out.truncation_um, voxel = out.voxel_um;
  in.require(band >= voxel && band <= 100 * voxel, "map.truncation_um", "not from 1 to 100 voxels");
  out.blocks = in.get<std::uint32_t>("map.blocks");
  in.require(out.blocks >= 1 && out.blocks <= MapParameters::kMostBlocks, "map.blocks", "not from 1 to 2^24");
  return out;
}

UpDirection read_up(FieldReader& in) {
  UpDirection out;
  double squared = 0;
  for (std::int32_t& v : out.millionths) {
    v = in.get<std::int32_t>("up");
    squared += static_cast<double>(v) * v * 1e-12;
  }
  in.require(squared > 0.99 && squared < 1.01, "up", "not of unit length");
  return out;
}

}  // namespace

UpDirection up_direction(const Vector3f& up) {
  UpDirection out;
  for (int i = 0; i < 3; ++i)
    out.millionths[static_cast<std::size_t>(i)] =
        static_cast<std::int32_t>(std::lround(1e6 * static_cast<double>(up[i])));
  return out;
}

Vector3f unit_vector(const UpDirection& up) {
  const auto& m = up.millionths;
  return Vector3d(m[0], m[1], m[2]).normalized().cast<float>();
}

SolutionRecord alone_on_map(const ChainId& chain) {
  SolutionRecord out;
  out.reference = chain;
  out.robots.push_back({chain, {}});
  return out;
}

std::vector<std::uint8_t> encode(const SolutionRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.reference);
  out.put(static_cast<std::uint16_t>(record.robots.size()));
  for (const SolvedRobot& solved : record.robots) put_robot(out, solved);
  out.put(record.links_used);
  out.put(record.links_refused);
  out.put(record.map.voxel_um);
  out.put(record.map.truncation_um);
  out.put(record.map.blocks);
  for (const std::int32_t v : record.up.millionths) out.put(v);
  return body;
}

std::uint64_t digest(const SolutionRecord& record) {
  const std::vector<std::uint8_t> body = encode(record);
  return XXH64(body.data(), body.size(), 0);
}

Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body) {
  FieldReader in("solution", body);
  SolutionRecord out;
  out.reference = in.chain("reference");
  const std::size_t n = in.count<std::uint16_t>(kMaxRobots, kRobotBytes, "robots");
  out.robots.resize(n);
  bool has_reference = false;
  for (std::size_t i = 0; i < n; ++i) {
    out.robots[i] = read_robot(in);
    in.require(i == 0 || out.robots[i - 1].chain < out.robots[i].chain, "robots.chain", "not sorted");
    has_reference = has_reference || out.robots[i].chain == out.reference;
  }
  in.require(has_reference, "reference", "not among the robots");
  out.links_used = in.get<std::uint32_t>("links_used");
  out.links_refused = in.get<std::uint32_t>("links_refused");
  out.map = read_parameters(in);
  out.up = read_up(in);
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
