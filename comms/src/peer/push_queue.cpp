#include "peer/push_queue.hpp"

#include <algorithm>
#include <utility>

namespace onemap::comms {

namespace {
constexpr double kMayBeLost = 0.002;
constexpr unsigned kMostCopies = 3;
}  // namespace

unsigned PushQueue::copies(double loss) {
  unsigned n = 1;
  for (double lost = loss; lost > kMayBeLost && n < kMostCopies; lost *= loss) ++n;
  return n;
}

bool PushQueue::push(std::shared_ptr<const Whole> record, Instant now, double loss) {
  if (waiting_.size() >= kMost) return false;
  // Before the copies of earlier ones, which are due later.
  auto at = waiting_.begin();
  while (at != waiting_.end() && at->at <= now) ++at;
  waiting_.insert(at, {now, std::move(record), copies(loss)});
  return true;
}

bool PushQueue::holds(const RecordId& id) const {
  return std::ranges::any_of(waiting_, [&](const Push& push) { return push.record->id == id; });
}

wire::Data PushQueue::front() const {
  const Push& push = waiting_.front();
  wire::Data data;
  data.id = push.record->id;
  data.kind = push.record->kind;
  data.total_bytes = static_cast<std::uint32_t>(push.record->payload.size());
  data.body_hash = push.record->hash;
  data.bytes = push.record->payload;
  return data;
}

void PushQueue::sent(Instant now) {
  Push push = std::move(waiting_.front());
  waiting_.pop_front();
  if (--push.copies == 0) return;
  push.at = now + kApart;
  auto at = waiting_.end();
  while (at != waiting_.begin() && std::prev(at)->at > push.at) --at;
  waiting_.insert(at, std::move(push));
}

}  // namespace onemap::comms
