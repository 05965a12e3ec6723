#pragma once
#include "mapping/records/kind.hpp"

namespace onemap::mapping {

// Of these kinds a robot's last record counts, and nobody reads an earlier one of its log again, so its body may be
// dropped: no map depends on whether one holds it.
constexpr bool only_the_last_counts(RecordKind kind) {
  return kind == RecordKind::solution || kind == RecordKind::frontier;
}

// Of these kinds a later record may say that it replaces an earlier one, whose body is dropped when no map is made of
// it any more (mapping/team/submap_log.hpp), or when what remains of it is known (mapping/team/keyframe_log.hpp).
constexpr bool may_be_replaced(RecordKind kind) { return kind == RecordKind::submap || kind == RecordKind::keyframe; }

}  // namespace onemap::mapping
