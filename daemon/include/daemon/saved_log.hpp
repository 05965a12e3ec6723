#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"
#include "comms/record_head.hpp"

namespace onemap::daemon {

// What others may hear of now: how many records of each log the store has promised to keep.
VersionVector durable_part(const comms::LogStore& store);

// The records of a team in a folder, as a robot keeps them in OUT/log: its map, in which any robot can go on.
class SavedLog {
 public:
  struct Saved {
    std::size_t records = 0, bytes = 0;  // of files
    std::size_t left_out = 0;            // could not be read, or follow such a one
  };
  // Writes the records of `logs` into a folder, which is there whole and for good, or not at all. The store's find()
  // must be for any thread. A body may go while it is written, for a record that is beyond `logs`: then as many more
  // of that log are written, of which `durable` says how many there are now. The error says why nothing is saved.
  using Durable = std::function<std::uint32_t(const LogId&)>;
  static Result<Saved> save(const comms::LogStore& from, const VersionVector& logs, const std::string& folder,
                            const std::atomic<bool>& stop, const Durable& durable = {});

  // Of a folder that stays as it is. The error says why there is nothing to read; `stop` ends the reading, and must
  // outlive this.
  static Result<std::unique_ptr<SavedLog>> open(const std::string& folder, const std::atomic<bool>& stop);

  struct Entry {
    Record record;
    std::optional<comms::SignedHead> by;  // if its body is gone, what made it needless
  };
  // Some of the records, log by log, that are not among `held`: at most kMostRecords, and kMostBytes and one record
  // more. None: that was all.
  static constexpr std::size_t kMostRecords = 32, kMostBytes = std::size_t{256} << 10;
  std::vector<Entry> next(const VersionVector& held);
  void skip(const LogId& log);  // nobody wants more of it

  const VersionVector& logs() const { return logs_; }
  std::size_t records() const;       // that are whole and have a place, as far as is known
  std::uint64_t unreadable() const;  // records that are not whole, as far as later ones tell, or follow such ones
  std::uint64_t spoilt_bytes() const { return store_->view().spoilt_bytes; }  // of files, that are no records

 private:
  bool begin_log(const VersionVector& held);
  void end_log();
  std::optional<comms::SignedHead> instead_of(const RecordId& id);

  std::unique_ptr<comms::PosixDisk> disk_;
  std::unique_ptr<comms::DiskStore> store_;
  VersionVector logs_;
  VersionVector::iterator log_;             // that is read
  std::optional<std::uint32_t> seq_;        // of its next record; nothing: it was not begun
  std::vector<std::uint32_t> replaced_by_;  // of it, by sequence; empty: not known yet
  std::uint64_t unreadable_ = 0;            // found while it was read
};

}  // namespace onemap::daemon
