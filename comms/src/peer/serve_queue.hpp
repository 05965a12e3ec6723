#pragma once
#include <array>
#include <cstdint>
#include <deque>

#include "comms/wire/payload.hpp"
#include "hal/base/record.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// What one neighbour asked for and did not get yet: ranges of fragments, first come first served within a lane, lower
// lanes first. Bounded by the asker's credit and by a number of ranges. Records are named here, not held: their bodies
// stay in the store.
class ServeQueue {
 public:
  explicit ServeQueue(Memory& memory = heap()) : lanes_(of_each_lane<std::pmr::deque<Range>>(memory)) {}
  enum class Answer { queued, already_queued, over_credit };
  // [first, end) must lie within the record's payload; of a dropped body there is one fragment, its head.
  Answer push(const RecordId& id, std::uint8_t hops, std::uint32_t first, std::uint32_t end, std::size_t credit_bytes);
  bool empty(std::uint8_t lane) const { return lanes_[lane].empty(); }
  bool empty() const { return queued_bytes_ == 0; }
  std::size_t queued_bytes() const { return queued_bytes_; }

  struct Next {
    RecordId id;
    std::uint8_t hops = 0;
    std::uint32_t fragment = 0;
  };
  Next front(std::uint8_t lane) const;  // the lane must not be empty
  void pop(std::uint8_t lane);
  void clear();
  void pop_record(std::uint8_t lane);  // all that is left of the range in front: there is no such body any more

 private:
  static constexpr std::size_t kMaxRanges = 1024;
  struct Range {
    RecordId id;
    std::uint8_t hops = 0;
    std::uint32_t next = 0, end = 0;
  };
  std::array<std::pmr::deque<Range>, kLaneCount> lanes_;
  std::size_t queued_bytes_ = 0, ranges_ = 0;
};

}  // namespace onemap::comms
