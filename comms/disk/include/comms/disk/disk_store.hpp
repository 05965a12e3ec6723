#pragma once
#include <memory>
#include <string>
#include <vector>

#include "comms/disk/disk.hpp"
#include "comms/log_store.hpp"

namespace onemap::comms {

struct DiskStoreConfig {
  std::size_t budget_bytes = std::size_t{2048} << 20;  // of files, everybody's records together
  std::size_t author_bytes = 0;                        // one robot's records; 0: half of the budget
  std::size_t segment_bytes = 0;                       // of one file; 0: a 32nd of the budget, 64 KiB to 64 MiB
  std::size_t index_bytes = std::size_t{5} << 20;      // in memory: eight bytes a record
  std::size_t cache_bytes = std::size_t{1} << 20;      // in memory: bodies that were used lately
  std::size_t waiting_bytes = std::size_t{3} << 19;    // in memory: what is not on the disk yet, or cannot get there
};

// A LogStore on a disk: it outlives the process and, as far as durable() says, the machine's power.
//
// All logs share one stream of records in segment files, because a memory card likes one place to write at: what comes
// in 50 ms from twenty robots becomes durable with one fdatasync. Beside what it has on the disk a record costs eight
// bytes here; bodies are read back when somebody wants them.
//
// Full is a state. The last tenth of the budget, and of each author's, is for lanes 0 and 1. When the disk itself has
// no room, fails or is gone, records of lanes 0 and 1 are kept in memory, as many as fit there, and written when it is
// back; other records are refused. Each has a word and a counter.
//
// At the start all segments are read: the last one is cut at the first frame that is not whole, and behind a spoilt
// place in an earlier one the records go on that can still follow each other. What is no segment is set aside.
//
// append, sync, durable and forget are for one thread; find and read may be called by any at the same time.
class DiskStore final : public LogStore {
 public:
  // The disk must outlive the store. The error says why nothing can be kept there at all.
  static Result<std::unique_ptr<DiskStore>> open(Disk& disk, const DiskStoreConfig& config);
  ~DiskStore() override;  // what was appended is made durable, as far as it goes

  Status append(Record record) override;
  Status sync() override;
  std::uint32_t durable(const LogId& log) const override;
  std::shared_ptr<const Record> find(const RecordId& id) const override;
  std::shared_ptr<const Record> read(const RecordId& id) const;  // as find(), and the cache stays as it is
  void scan(const std::function<void(const std::shared_ptr<const Record>&)>& visit) const override;
  bool forget(const RecordId& id) override;
  const VersionVector& frontier() const override;
  std::size_t bytes() const override;  // of files

  void flush();  // waits until all that can be durable is

  struct View {
    DiskFault fault = DiskFault::none;  // now
    std::uint64_t faults = 0;           // so often it began not to work
    std::uint64_t records = 0, bytes = 0, capacity = 0;
    std::uint64_t dropped_bodies = 0;   // forgotten, since the start
    std::uint64_t reclaimed_bytes = 0;  // of files, since the start
    std::uint64_t waiting_records = 0;  // that are not durable yet
    std::uint64_t refused_full = 0;     // by the budget, the author's or the index
    std::uint64_t refused_by_disk = 0;  // because it has no room or fails
    std::uint64_t unreadable = 0;       // could not be read back
    std::uint64_t cut_bytes = 0;        // torn off the end at the start: they were never told to anybody
    std::uint64_t spoilt_bytes = 0;     // that were no whole frames at the start, those of cut_bytes among them
    std::uint64_t lost_records = 0;     // behind a spoilt place, at the start: to be got from neighbours
    std::uint64_t memory_bytes = 0;     // that it may hold at most
    std::vector<std::string> messages;  // what was found at the start, for people
  };
  View view() const;

 private:
  struct Impl;
  explicit DiskStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::comms
