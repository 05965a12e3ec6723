#include "peer/serve_queue.hpp"

#include <algorithm>
#include <cassert>

namespace onemap::comms {

ServeQueue::Answer ServeQueue::push(const RecordId& id, std::uint8_t hops, std::uint32_t first, std::uint32_t end,
                                    std::size_t credit_bytes) {
  auto& lane = lanes_[id.log.lane];
  // An asker that lost patience asks again for what still waits here. Ranges are in ascending order and short, so
  // clipping at both ends removes what is queued in all but contrived cases (then it is sent twice, which is harmless).
  for (const Range& queued : lane) {
    if (queued.id != id) continue;
    if (queued.next <= first) first = std::max(first, std::min(queued.end, end));
    if (queued.end >= end) end = std::min(end, std::max(queued.next, first));
    if (first >= end) return Answer::already_queued;
  }
  const std::size_t bytes = (end - first) * wire::kFragmentBytes;
  if (queued_bytes_ + bytes > credit_bytes || ranges_ >= kMaxRanges) return Answer::over_credit;
  queued_bytes_ += bytes;
  ++ranges_;
  lane.push_back({id, hops, first, end});
  return Answer::queued;
}

ServeQueue::Next ServeQueue::front(std::uint8_t lane) const {
  assert(!lanes_[lane].empty());
  const Range& range = lanes_[lane].front();
  return {range.id, range.hops, range.next};
}

void ServeQueue::pop(std::uint8_t lane) {
  Range& range = lanes_[lane].front();
  queued_bytes_ -= wire::kFragmentBytes;
  if (++range.next < range.end) return;
  lanes_[lane].pop_front();
  --ranges_;
}

void ServeQueue::clear() {
  for (auto& lane : lanes_) lane.clear();
  queued_bytes_ = ranges_ = 0;
}

void ServeQueue::pop_record(std::uint8_t lane) {
  const Range& range = lanes_[lane].front();
  queued_bytes_ -= (range.end - range.next) * wire::kFragmentBytes;
  lanes_[lane].pop_front();
  --ranges_;
}

}  // namespace onemap::comms
