// What a robot that only listens makes of a file of records: the digest of the team's map. Built by several compilers
// and for several processors (.ci/same-digest), it must be one number.
//   digest_of_records FILE
#include <cstdio>
#include <map>
#include <memory>
#include <set>

#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "mapping/team/team_map.hpp"

namespace {

using namespace onemap;
using namespace onemap::mapping;

std::vector<RecordPtr> read(const std::vector<std::uint8_t>& bytes) {
  std::vector<RecordPtr> out;
  ByteReader in(bytes);
  while (in.ok() && !in.done()) {
    Record record;
    const std::size_t length = in.get<std::uint8_t>();
    const auto name = in.bytes(length);
    record.id.log.robot = RobotId::from_name({reinterpret_cast<const char*>(name.data()), name.size()});
    record.id.log.lane = in.get<std::uint8_t>();
    record.id.log.incarnation = in.get<std::uint64_t>();
    record.id.seq = in.get<std::uint32_t>();
    record.kind = in.get<std::uint16_t>();
    const auto size = in.get<std::uint32_t>();
    const auto body = in.bytes(size);
    record.body.assign(body.begin(), body.end());
    if (in.ok()) out.push_back(std::make_shared<const Record>(std::move(record)));
  }
  return in.ok() ? out : std::vector<RecordPtr>{};
}

}  // namespace

int main(int argc, char** argv) {
  const auto bytes = argc == 2 ? read_file(argv[1]) : Result<std::vector<std::uint8_t>>(Error{"FILE", "not given"});
  if (!bytes) return std::fprintf(stderr, "%s\n", bytes.error().text().c_str()), 2;
  TeamMapConfig config;
  config.atlas.map.budget_bytes = 64u << 20;
  TeamMap map(RobotId::from_name("listener"), 1, config);
  std::map<RobotId, Instant> heard;
  for (const RecordPtr& record : read(*bytes)) {
    map.apply(record, {});
    heard[record->id.log.robot] = {};
  }
  map.presence(heard, {});
  while (map.step({})) map.observe({});
  map.observe({});
  if (!map.view().settled) return std::fprintf(stderr, "%s: no settled map\n", argv[1]), 1;
  std::printf("%016llx %zu blocks\n", static_cast<unsigned long long>(map.view().digest), map.map()->used());
  return 0;
}
