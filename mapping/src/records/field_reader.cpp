#include "records/field_reader.hpp"

#include <algorithm>

namespace onemap::mapping {
namespace {

// Rounding to 2^-30 moves the length by less than 2^-29; anything else was not a rotation.
bool unit_length(const std::array<std::int32_t, 4>& q) {
  double sum = 0;
  for (const std::int32_t c : q) sum += (c / 1073741824.0) * (c / 1073741824.0);
  return sum > 0.999999 && sum < 1.000001;
}

}  // namespace

RobotId FieldReader::robot(std::string_view field) {
  RobotId id;
  const auto part = bytes(id.bytes.size(), field);
  if (part.size() == id.bytes.size()) std::copy(part.begin(), part.end(), id.bytes.begin());
  require(id.valid(), field, "no robot's name");
  return ok() ? id : RobotId{};
}

ChainId FieldReader::chain(std::string_view field) {
  const RobotId id = robot(field);
  return {id, get<std::uint64_t>(field)};
}

QuantizedPose FieldReader::pose(std::string_view field) {
  QuantizedPose out;
  for (auto& t : out.t_10um) t = get<std::int32_t>(field);
  for (auto& q : out.q_wxyz) q = get<std::int32_t>(field);
  require(out.q_wxyz[0] >= 0 && unit_length(out.q_wxyz), field, "not a unit quaternion with w >= 0");
  return out;
}

void put(ByteWriter& out, const RobotId& robot) { out.bytes(robot.bytes); }

void put(ByteWriter& out, const ChainId& chain) {
  put(out, chain.robot);
  out.put(chain.incarnation);
}

void put(ByteWriter& out, const QuantizedPose& pose) {
  for (const std::int32_t t : pose.t_10um) out.put(t);
  for (const std::int32_t q : pose.q_wxyz) out.put(q);
}

void put(ByteWriter& out, FrameTime time) { out.put<std::int64_t>(time.time_since_epoch().count()); }

}  // namespace onemap::mapping
