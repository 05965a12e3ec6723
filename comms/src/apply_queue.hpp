#pragma once
#include <deque>
#include <optional>

#include "hal/base/record.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Records that were stored and not given out yet, in order, as ranges of their logs: a store that was full of records
// at the start costs a place a log.
class ApplyQueue {
 public:
  explicit ApplyQueue(Memory& memory = heap()) : ranges_(&memory) {}
  void push(const LogId& log, std::uint32_t first, std::uint32_t end) {
    if (!ranges_.empty() && ranges_.back().log == log && ranges_.back().end == first)
      ranges_.back().end = end;
    else
      ranges_.push_back({log, first, end});
  }
  std::optional<RecordId> pop() {
    if (ranges_.empty()) return std::nullopt;
    Range& range = ranges_.front();
    const RecordId id{range.log, range.first++};
    if (range.first == range.end) ranges_.pop_front();
    return id;
  }

 private:
  struct Range {
    LogId log;
    std::uint32_t first = 0, end = 0;
  };
  std::pmr::deque<Range> ranges_;
};

}  // namespace onemap::comms
