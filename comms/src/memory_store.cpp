#include "comms/memory_store.hpp"

#include <string>
#include <utility>

#include "comms/record_head.hpp"
#include "comms/store_share.hpp"

namespace onemap::comms {

namespace {
std::size_t cost_of(const Record& record) { return record.body.size() + MemoryStore::kRecordBytes; }

std::string name_of(const LogId& log) { return "log " + log.robot.name() + "/" + std::to_string(log.lane); }
}  // namespace

MemoryStore::MemoryStore(std::size_t budget_bytes) : budget_(budget_bytes) {}

Status MemoryStore::append(Record record) {
  const LogId id = record.id.log;
  const auto log = logs_.find(id);
  const std::size_t next = log == logs_.end() ? 0 : log->second.size();
  if (record.id.seq != next)
    return Error{name_of(id),
                 "record " + std::to_string(record.id.seq) + " is not the next, which is " + std::to_string(next)};
  const std::size_t cost = cost_of(record) + (next == 0 ? kLogBytes : 0);
  const std::size_t limit = share_for(record, budget_);
  if (used_ > limit || cost > limit - used_) return full(record);
  logs_[id].push_back(std::make_shared<const Record>(std::move(record)));
  frontier_[id] = static_cast<std::uint32_t>(next + 1);
  used_ += cost;
  return success();
}

Error MemoryStore::full(const Record& record) const {
  return {"the store is full", std::to_string(used_) + " of " + std::to_string(budget_) +
                                   " bytes (network.store_budget_mb) are used" + what_is_left(record.id.log) +
                                   "; a record of " + record.id.log.robot.name() + " with " +
                                   std::to_string(record.body.size()) + " bytes is not kept"};
}

std::shared_ptr<const Record> MemoryStore::find(const RecordId& id) const {
  const auto log = logs_.find(id.log);
  if (log == logs_.end() || id.seq >= log->second.size()) return nullptr;
  return log->second[id.seq];
}

void MemoryStore::scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const {
  for (const auto& [id, records] : logs_)
    for (const auto& record : records) visit(record);
}

bool MemoryStore::forget(const RecordId& id) {
  const auto log = logs_.find(id.log);
  if (log == logs_.end() || id.seq >= log->second.size() || log->second[id.seq]->dropped) return false;
  std::shared_ptr<const Record>& record = log->second[id.seq];
  used_ -= record->body.size();
  record = std::make_shared<const Record>(without_body(*record));
  return true;
}

}  // namespace onemap::comms
