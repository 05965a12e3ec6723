#include "comms/disk/disk_store.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "comms/record_head.hpp"
#include "comms/store_share.hpp"
#include "disk_store_impl.hpp"

namespace onemap::comms {

using segment::frame_bytes;
using segment::name_of;

namespace {
constexpr std::size_t kLeastSegment = std::size_t{64} << 10, kMostSegment = std::size_t{64} << 20;
constexpr std::size_t kCleanAtOnce = std::size_t{256} << 10;

DiskStoreConfig filled(DiskStoreConfig config) {
  if (config.segment_bytes == 0)
    config.segment_bytes = std::clamp(config.budget_bytes / 32, kLeastSegment, kMostSegment);
  if (config.author_bytes == 0) config.author_bytes = config.budget_bytes / 2;
  return config;
}
}  // namespace

DiskStore::Impl::Impl(Disk& disk_, const DiskStoreConfig& config_)
    : disk(disk_), config(filled(config_)), index(config.index_bytes), cache(config.cache_bytes) {
  view.capacity = config.budget_bytes;
  view.memory_bytes = index.capacity_bytes() + config.cache_bytes + config.waiting_bytes + 2 * segment::kMaxFrameBytes;
}

Status DiskStore::Impl::append(Record record) {
  const RecordId id = record.id;
  if (id.seq != index.count(id.log))
    return Error{fmt::format("log {}/{}", id.log.robot.name(), id.log.lane),
                 fmt::format("record {} is not the next, which is {}", id.seq, index.count(id.log))};
  const std::size_t cost = frame_bytes(record.body.size());
  const std::size_t room = config.budget_bytes - std::min(config.budget_bytes, config.segment_bytes);
  const std::size_t limit = share_for(record, room);
  if (used + cost > limit - limit / 8) clean(kCleanAtOnce + 4 * cost);
  if (used + cost > limit) return full(record, fmt::format("{} of {} bytes are used", used, config.budget_bytes));
  const std::uint64_t of_it = of_author[id.log.robot];
  if (of_it + cost > share_for(record, config.author_bytes))
    return full(record, fmt::format("{} of the {} bytes that one robot may have are used", of_it, config.author_bytes));
  if (!index.has_room_for(id.log)) return full(record, "there are as many records as its index has places for");

  const bool bulk = is_bulk(id.log);
  if (waiting_bytes + cost > config.waiting_bytes && view.fault == DiskFault::none) {
    if (!syncing && unsynced) begin_sync();
    if (syncing) finish_sync(*disk.synced(true));  // who writes faster than the disk waits for it
  }
  const bool no_memory = waiting_bytes + cost > config.waiting_bytes;
  if (no_memory && view.fault != DiskFault::none) return refused_by_disk(record, view.fault);
  Waiting entry{std::make_shared<const Record>(std::move(record)), false};
  RecordPlace place;
  const DiskFault fault = write_frame(*entry.record, place);
  works(fault);
  if (fault != DiskFault::none && (bulk || no_memory)) return refused_by_disk(*entry.record, fault);
  entry.written = fault == DiskFault::none;
  place.in_memory = !entry.written;
  index.push(id.log, place);
  frontier[id.log] = id.seq + 1;
  of_author[id.log.robot] += cost;
  waiting_bytes += cost;
  cache.keep(entry.record);
  waiting.push_back(std::move(entry));
  return success();
}

Error DiskStore::Impl::refused_by_disk(const Record& record, DiskFault fault) {
  ++view.refused_by_disk;
  return {"the disk", fmt::format("{}; a record of {} with {} bytes is not kept", words(fault),
                                  record.id.log.robot.name(), record.body.size())};
}

Error DiskStore::Impl::full(const Record& record, const std::string& of_what) const {
  return {"the log is full",
          fmt::format("{} (network.store_budget_mb){}; a record of {} with {} bytes is not kept", of_what,
                      what_is_left(record.id.log), record.id.log.robot.name(), record.body.size())};
}

DiskFault DiskStore::Impl::write_frame(const Record& record, RecordPlace& place) {
  const std::size_t size = frame_bytes(record.body.size());
  if (active_spoilt || (segments[active].bytes > 0 && segments[active].bytes + size > config.segment_bytes))
    if (const DiskFault fault = roll(); fault != DiskFault::none) return fault;
  Segment& to = segments[active];
  segment::write_frame(record, active, buffer);
  const DiskFault fault = disk.write(name_of(active), to.bytes, buffer);
  if (fault != DiskFault::none) {
    // What was written of it must not stand before the next one.
    if (to.bytes > 0 && disk.cut(name_of(active), to.bytes) != DiskFault::none) spoil_active();
    return fault;
  }
  place = {active, static_cast<std::uint32_t>(to.bytes), record.dropped.has_value(), false, false};
  to.bytes += buffer.size();
  used += buffer.size();
  unsynced = true;
  return fault;
}

// Only the segment that is written to has anything that is not durable.
DiskFault DiskStore::Impl::roll() {
  if (!active_spoilt) {
    if (syncing) finish_sync(*disk.synced(true));
    if (unsynced && !active_spoilt) {
      begin_sync();
      finish_sync(*disk.synced(true));
    }
    if (active_spoilt) return view.fault;
  }
  active_spoilt = false;
  ++active;
  segments[active] = {};
  return DiskFault::none;
}

Status DiskStore::Impl::sync() {
  if (syncing) {
    const auto result = disk.synced(false);
    if (!result) return success();
    finish_sync(*result);
  }
  for (Waiting& entry : waiting) {
    if (entry.written) continue;
    RecordPlace place;
    const DiskFault fault = write_frame(*entry.record, place);
    works(fault);
    if (fault != DiskFault::none) return Error{"the disk", std::string(words(fault))};
    entry.written = true;
    index.set(entry.record->id, place);
  }
  if (!unsynced) return success();
  begin_sync();
  if (const auto result = disk.synced(false)) finish_sync(*result);
  return view.fault == DiskFault::none ? success() : Status(Error{"the disk", std::string(words(view.fault))});
}

void DiskStore::Impl::begin_sync() {
  syncing = true;
  unsynced = false;
  being_synced = waiting.size();
  if (cleaning && cleaning->copied) cleaning->covered = true;
  disk.begin_sync(name_of(active));
}

void DiskStore::Impl::finish_sync(DiskFault fault) {
  syncing = false;
  works(fault);
  if (fault != DiskFault::none) return spoil_active();
  std::deque<Waiting> still;
  for (std::size_t k = 0; k < being_synced; ++k) {
    Waiting& entry = waiting[k];
    const RecordId& id = entry.record->id;
    if (!entry.written) {
      still.push_back(std::move(entry));
      continue;
    }
    waiting_bytes -= frame_bytes(entry.record->body.size());
    durable_to[id.log] = std::max(durable_to[id.log], id.seq + 1);
  }
  waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(being_synced));
  waiting.insert(waiting.begin(), std::make_move_iterator(still.begin()), std::make_move_iterator(still.end()));
  being_synced = 0;
  copied_is_durable();
}

// After a sync that failed nobody knows what of it is on the disk, and the next one may say that all is well: all that
// waits is written again, elsewhere.
void DiskStore::Impl::spoil_active() {
  active_spoilt = true;
  unsynced = false;
  being_synced = 0;
  if (cleaning) segments[cleaning->segment].dead = 0;  // its copies may be gone: it stays for good
  cleaning.reset();
  for (Waiting& entry : waiting) {
    if (!entry.written) continue;
    entry.written = false;
    RecordPlace place = index.get(entry.record->id);
    segments[place.segment].dead += frame_bytes(entry.record->body.size());
    place.in_memory = true;
    index.set(entry.record->id, place);
  }
}

void DiskStore::Impl::works(DiskFault fault) {
  if (fault != DiskFault::none && view.fault == DiskFault::none) ++view.faults;
  view.fault = fault;
}

// A robot whose disk does not work goes on telling where it is, without a promise.
std::uint32_t DiskStore::Impl::durable(const LogId& log) const {
  if (view.fault != DiskFault::none && !is_bulk(log)) return index.count(log);
  const auto at = durable_to.find(log);
  return at == durable_to.end() ? 0 : at->second;
}

// keep: in the cache.
std::shared_ptr<const Record> DiskStore::Impl::find(const RecordId& id, bool keep) {
  if (!index.holds(id)) return nullptr;
  const RecordPlace place = index.get(id);
  if (place.in_memory) {
    const auto same = [&](const Waiting& entry) { return entry.record->id == id; };
    const auto at = std::find_if(waiting.begin(), waiting.end(), same);
    return at == waiting.end() ? nullptr : at->record;
  }
  if (auto record = cache.find(id)) return record;
  auto record = read(id, place);
  if (record == nullptr)
    ++view.unreadable;
  else if (keep)
    cache.keep(record);
  return record;
}

std::shared_ptr<const Record> DiskStore::Impl::read(const RecordId& id, const RecordPlace& place) {
  const std::string name = name_of(place.segment);
  std::vector<std::uint8_t> bytes(segment::kFixedBytes);
  if (disk.read(name, place.at, bytes) != bytes.size()) return nullptr;
  const auto head = segment::read_head(bytes);
  if (!head || head->id != id) return nullptr;
  auto record = std::make_shared<Record>(Record{id, head->kind, {}, head->seal, {}});
  if (head->dropped || place.dropped) {
    record->dropped = DroppedBody{head->bytes, head->digest};
    return record;
  }
  bytes.resize(segment::kFixedBytes + head->bytes);
  const std::span body = std::span(bytes).subspan(segment::kFixedBytes);
  if (disk.read(name, place.at + segment::kFixedBytes, body) != body.size()) return nullptr;
  if (!segment::is_whole(bytes, place.segment)) return nullptr;
  record->body.assign(body.begin(), body.end());
  return record;
}

DiskStore::DiskStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DiskStore::~DiskStore() { flush(); }

Result<std::unique_ptr<DiskStore>> DiskStore::open(Disk& disk, const DiskStoreConfig& config) {
  auto impl = std::make_unique<Impl>(disk, config);
  if (auto loaded = impl->load(); !loaded) return loaded.error();
  return std::unique_ptr<DiskStore>(new DiskStore(std::move(impl)));
}

Status DiskStore::append(Record record) {
  const std::lock_guard lock(impl_->mutex);
  auto kept = impl_->append(std::move(record));
  if (!kept && kept.error().place == "the log is full") ++impl_->view.refused_full;
  return kept;
}
Status DiskStore::sync() {
  const std::lock_guard lock(impl_->mutex);
  return impl_->sync();
}
std::uint32_t DiskStore::durable(const LogId& log) const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->durable(log);
}
std::shared_ptr<const Record> DiskStore::find(const RecordId& id) const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->find(id, true);
}
std::shared_ptr<const Record> DiskStore::read(const RecordId& id) const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->find(id, false);
}
bool DiskStore::forget(const RecordId& id) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->forget(id);
}
const VersionVector& DiskStore::frontier() const { return impl_->frontier; }
std::size_t DiskStore::bytes() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->used;
}

void DiskStore::scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const {
  for (const auto& [log, count] : impl_->frontier)
    for (std::uint32_t seq = 0; seq < count; ++seq)
      if (const auto record = find({log, seq})) visit(record);
}

void DiskStore::flush() {
  const std::lock_guard lock(impl_->mutex);
  for (int round = 0; round < 3; ++round) {  // what was written while a sync went on needs another
    if (impl_->syncing) impl_->finish_sync(*impl_->disk.synced(true));
    if (impl_->waiting.empty() || !impl_->sync()) return;
  }
  if (impl_->syncing) impl_->finish_sync(*impl_->disk.synced(true));
}

DiskStore::View DiskStore::view() const {
  const std::lock_guard lock(impl_->mutex);
  View view = impl_->view;
  view.bytes = impl_->used;
  view.waiting_records = impl_->waiting.size();
  for (const auto& [log, count] : impl_->frontier) view.records += count;
  return view;
}

}  // namespace onemap::comms
