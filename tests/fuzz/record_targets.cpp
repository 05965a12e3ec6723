#include <algorithm>

#include "fuzz/expect.hpp"
#include "fuzz/targets.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/frontier.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/ruling.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::fuzz {

namespace {
using namespace mapping;

// One form for one value: what can be read is what would be written.
template <class Read>
void canonical(Bytes body, Read read) {
  const auto value = read(body);
  if (!value) return ONEMAP_FUZZ_EXPECT(!value.error().reason.empty());
  const auto again = encode(*value);
  ONEMAP_FUZZ_EXPECT(std::equal(body.begin(), body.end(), again.begin(), again.end()));
}

// Where a part is compressed, or rounded, it is so from the first writing on.
template <class Read>
void settled(Bytes body, Read read) {
  const auto value = read(body);
  if (!value) return ONEMAP_FUZZ_EXPECT(!value.error().reason.empty());
  const auto once = encode(*value);
  const auto same = read(once);
  ONEMAP_FUZZ_EXPECT(same.ok());
  ONEMAP_FUZZ_EXPECT(encode(*same) == once);
}
}  // namespace

void record(Bytes input) {
  if (input.empty()) return;
  const Bytes body = input.subspan(1);
  switch (static_cast<RecordKind>(input[0])) {
    case RecordKind::hello:
      return canonical(body, decode_hello);
    case RecordKind::keyframe:
      return settled(body, decode_keyframe);
    case RecordKind::trajectory:
      return canonical(body, decode_trajectory);
    case RecordKind::submap:
      (void)decode_submap_header(body);
      return settled(body, decode_submap);
    case RecordKind::link:
      return canonical(body, decode_link);
    case RecordKind::solution:
      return canonical(body, decode_solution);
    case RecordKind::finished:
      return canonical(body, decode_finished);
    case RecordKind::frontier:
      return canonical(body, decode_frontier);
    case RecordKind::ruling:
      return canonical(body, decode_ruling);
  }
}

}  // namespace onemap::fuzz
