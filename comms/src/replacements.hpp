#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "hal/base/record.hpp"

namespace onemap::comms {

// Of the kinds of which only the last record of a log counts, which one that is.
class LastOfKind {
 public:
  using Counts = std::function<bool(std::uint16_t kind)>;
  explicit LastOfKind(Counts only_the_last_counts) : only_the_last_counts_(std::move(only_the_last_counts)) {}

  // Records of one log in their order. The one whose place it takes; nothing: none's.
  std::optional<RecordId> took(const Record& record) {
    if (!only_the_last_counts_ || !only_the_last_counts_(record.kind)) return std::nullopt;
    const auto [last, first_one] = last_.try_emplace({record.id.log, record.kind}, record.id.seq);
    if (first_one || record.id.seq <= last->second) return std::nullopt;
    return RecordId{record.id.log, std::exchange(last->second, record.id.seq)};
  }
  // What took the place of this record; nothing: it still counts.
  std::optional<RecordId> instead_of(const RecordId& id, std::uint16_t kind) const {
    const auto last = last_.find({id.log, kind});
    if (last == last_.end() || last->second <= id.seq) return std::nullopt;
    return RecordId{id.log, last->second};
  }

 private:
  Counts only_the_last_counts_;
  std::map<std::pair<LogId, std::uint16_t>, std::uint32_t> last_;  // sequence
};

}  // namespace onemap::comms
