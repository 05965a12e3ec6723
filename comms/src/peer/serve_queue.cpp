#include "peer/serve_queue.hpp"

#include <algorithm>
#include <cassert>
#include <span>

namespace onemap::comms {

ServeQueue::Answer ServeQueue::push(std::shared_ptr<const Record> record, std::uint64_t hash, std::uint8_t hops,
                                    std::uint32_t first, std::uint32_t end, std::size_t credit_bytes) {
  auto& lane = lanes_[record->id.log.lane];
  // An asker that lost patience asks again for what still waits here. Ranges are in ascending order and short, so
  // clipping at both ends removes what is queued in all but contrived cases (then it is sent twice, which is harmless).
  for (const Range& queued : lane) {
    if (queued.record->id != record->id) continue;
    if (queued.next <= first) first = std::max(first, std::min(queued.end, end));
    if (queued.end >= end) end = std::min(end, std::max(queued.next, first));
    if (first >= end) return Answer::already_queued;
  }
  const std::size_t bytes = (end - first) * wire::kFragmentBytes;
  if (queued_bytes_ + bytes > credit_bytes || ranges_ >= kMaxRanges) return Answer::over_credit;
  queued_bytes_ += bytes;
  ++ranges_;
  lane.push_back({std::move(record), hash, hops, first, end});
  return Answer::queued;
}

wire::Data ServeQueue::front(std::uint8_t lane) const {
  assert(!lanes_[lane].empty());
  const Range& range = lanes_[lane].front();
  const Record& record = *range.record;
  wire::Data data;
  data.id = record.id;
  data.kind = record.kind;
  data.hops = range.hops;
  data.total_bytes = static_cast<std::uint32_t>(record.body.size());
  data.body_hash = range.hash;
  data.fragment = static_cast<std::uint16_t>(range.next);
  const std::size_t at = range.next * wire::kFragmentBytes;
  data.bytes = std::span(record.body).subspan(at, std::min(wire::kFragmentBytes, record.body.size() - at));
  return data;
}

void ServeQueue::pop(std::uint8_t lane) {
  Range& range = lanes_[lane].front();
  queued_bytes_ -= wire::kFragmentBytes;
  if (++range.next < range.end) return;
  lanes_[lane].pop_front();
  --ranges_;
}

}  // namespace onemap::comms
