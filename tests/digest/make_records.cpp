// Two simulated robots' records of one room, with all that their team wrote, for digest_of_records.
//   make_records FILE
#include <cstdio>

#include "hal/base/bytes.hpp"
#include "hal/base/file.hpp"
#include "support/team_robots.hpp"

namespace {

using namespace onemap;

void put(const Record& record, std::vector<std::uint8_t>& out) {
  ByteWriter writer(out);
  const std::string name = record.id.log.robot.name();
  writer.put(static_cast<std::uint8_t>(name.size()));
  writer.bytes({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()});
  writer.put(record.id.log.lane);
  writer.put(record.id.log.incarnation);
  writer.put(record.id.seq);
  writer.put(record.kind);
  writer.put(static_cast<std::uint32_t>(record.body.size()));
  writer.bytes(record.body);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  test::Robot one(test::first()), two(test::second());
  one.apply(test::first().written()), one.apply(test::second().written());
  two.apply(test::first().written()), two.apply(test::second().written());
  for (int i = 0; i < 4; ++i) two.apply(one.work()), one.apply(two.work());
  std::vector<std::uint8_t> bytes;
  for (const mapping::RecordPtr& record : one.held()) put(*record, bytes);
  const Status written = write_file(argv[1], bytes);
  if (!written) return std::fprintf(stderr, "%s\n", written.error().text().c_str()), 1;
  std::printf("%016llx %zu blocks\n", static_cast<unsigned long long>(one.view().digest), one.map().map()->used());
  return one.view().settled && one.view().robots_in_map == 2 ? 0 : 1;
}
