#include "comms/memory_store.hpp"

#include <utility>

namespace onemap::comms {

namespace {
constexpr std::uint8_t kFirstBulkLane = 2;  // features, voxels, imagery

std::size_t limit_for(std::uint8_t lane, std::size_t budget) {
  return lane < kFirstBulkLane ? budget : budget - budget / 10;
}
}  // namespace

MemoryStore::MemoryStore(std::size_t budget_bytes) : budget_(budget_bytes) {}

bool MemoryStore::append(Record record) {
  const LogId id = record.id.log;
  const auto log = logs_.find(id);
  const std::size_t next = log == logs_.end() ? 0 : log->second.size();
  if (record.id.seq != next) return ++refused_order_, false;
  const std::size_t cost = record.body.size() + kOverheadBytes;
  const std::size_t limit = limit_for(id.lane, budget_);
  if (used_ > limit || cost > limit - used_) return ++refused_full_, false;
  logs_[id].push_back(std::make_shared<const Record>(std::move(record)));
  frontier_[id] = static_cast<std::uint32_t>(next + 1);
  used_ += cost;
  return true;
}

std::shared_ptr<const Record> MemoryStore::find(const RecordId& id) const {
  const auto log = logs_.find(id.log);
  if (log == logs_.end() || id.seq >= log->second.size()) return nullptr;
  return log->second[id.seq];
}

}  // namespace onemap::comms
