#pragma once
#include <deque>
#include <map>
#include <mutex>
#include <optional>

#include "body_cache.hpp"
#include "comms/disk/disk_store.hpp"
#include "record_index.hpp"
#include "segment_frame.hpp"

namespace onemap::comms {

struct DiskStore::Impl {
  struct Segment {
    std::uint64_t bytes = 0;  // written
    std::uint64_t dead = 0;   // of them, frames and bodies that nobody needs
  };
  // Appended, and not durable yet.
  struct Waiting {
    std::shared_ptr<const Record> record;
    bool written = false;  // to the segment that is being written, if that does not fail
  };

  Impl(Disk& disk, const DiskStoreConfig& config);

  // disk_scan.cpp
  Status load();
  bool load_segment(std::uint32_t number, std::uint64_t bytes, bool last);
  void found(const segment::Head& head, std::uint32_t number, std::uint32_t at);
  void set_aside(const std::string& name, const std::string& why);

  // disk_store.cpp
  Status append(Record record);
  Status sync();
  void begin_sync();
  void finish_sync(DiskFault fault);
  void spoil_active();
  DiskFault write_waiting(Waiting& waiting);
  DiskFault write_frame(const Record& record, RecordPlace& place);
  DiskFault roll();
  void works(DiskFault fault);
  Error refused_by_disk(const Record& record, DiskFault fault);
  Error full(const Record& record, const std::string& of_what) const;
  std::shared_ptr<const Record> find(const RecordId& id, bool keep);
  std::shared_ptr<const Record> read(const RecordId& id, const RecordPlace& place);
  std::uint32_t durable(const LogId& log) const;

  // disk_clean.cpp
  bool forget(const RecordId& id);
  void clean(std::size_t bytes);
  void copied_is_durable();
  bool choose_victim();
  bool copy_some(std::size_t bytes);
  void bury(const segment::Head& head, const RecordPlace& place);  // that frame is not needed any more

  mutable std::mutex mutex;  // of all of this; not held while the disk syncs
  Disk& disk;
  DiskStoreConfig config;
  RecordIndex index;
  BodyCache cache;
  VersionVector frontier, durable_to;
  std::map<RobotId, std::uint64_t> of_author;  // bytes of frames that count
  std::map<std::uint32_t, Segment> segments;
  std::uint32_t active = 0;
  bool active_spoilt = false;  // nothing more is written there
  std::uint64_t used = 0;      // bytes of all segments

  std::deque<Waiting> waiting;
  std::size_t waiting_bytes = 0;
  bool syncing = false;
  std::size_t being_synced = 0;  // of `waiting`, from the front

  struct Cleaning {
    std::uint32_t segment = 0;
    std::uint64_t at = 0;
    bool copied = false;   // all of it; it goes when the copies are durable
    bool covered = false;  // by the sync that is going on
  };
  std::optional<Cleaning> cleaning;
  bool unsynced = false;  // something was written to the active segment since its last sync began

  std::vector<std::uint8_t> buffer;
  View view;
};

}  // namespace onemap::comms
