#include "mapping/records/solution.hpp"

#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxRobots = 1024;

}  // namespace

std::vector<std::uint8_t> encode(const SolutionRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.reference);
  out.put(static_cast<std::uint16_t>(record.robots.size()));
  for (const SolvedRobot& solved : record.robots) {
    put(out, solved.robot);
    put(out, solved.T_global_robot);
  }
  out.put(record.links_used);
  return body;
}

Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body) {
  FieldReader in("solution", body);
  SolutionRecord out;
  out.reference = in.robot("reference");
  const std::size_t n = in.count<std::uint16_t>(kMaxRobots, 16 + kPoseBytes, "robots");
  out.robots.resize(n);
  bool has_reference = false;
  for (std::size_t i = 0; i < n; ++i) {
    out.robots[i].robot = in.robot("robots.robot");
    out.robots[i].T_global_robot = in.pose("robots.T_global_robot");
    in.require(i == 0 || out.robots[i - 1].robot < out.robots[i].robot, "robots.robot", "not sorted");
    if (out.robots[i].robot != out.reference) continue;
    has_reference = true;
    in.require(out.robots[i].T_global_robot == QuantizedPose{}, "reference", "not at the origin of its own frame");
  }
  in.require(has_reference, "reference", "not among the robots");
  out.links_used = in.get<std::uint32_t>("links_used");
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
