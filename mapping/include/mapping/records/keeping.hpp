#pragma once
#include "mapping/records/kind.hpp"

namespace onemap::mapping {

// Of these kinds a robot's last record counts, and nobody reads an earlier one of its log again, so its body may be
// dropped: no map depends on whether one holds it.
constexpr bool only_the_last_counts(RecordKind kind) {
  return kind == RecordKind::solution || kind == RecordKind::frontier;
}

}  // namespace onemap::mapping
