#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "comms/log_store.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

using test::Random;

// What a robot's records lie on, beyond the life of a process. A store is open at most once, and closed before a crash
// is over.
class NodeDisk {
 public:
  virtual ~NodeDisk() = default;
  virtual std::unique_ptr<LogStore> open() = 0;
  // The power went: what was synced stays, and of the rest as much as chance leaves.
  virtual void crash(Random& random) = 0;
  virtual void wipe() = 0;
};

// No disk: records live in memory and die with the process, as onemapd's do until they are kept on a disk.
class NoDisk final : public NodeDisk {
 public:
  explicit NoDisk(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}
  std::unique_ptr<LogStore> open() override;
  void crash(Random&) override {}
  void wipe() override {}

 private:
  std::size_t budget_bytes_;
};

// One file of records that is only ever appended to, each with its checksum. sync() makes durable what is there; a
// crash cuts the rest anywhere, within a record, too, and may spoil what is left of it. Opening reads to the first
// record that is not whole and cuts there.
class JournalDisk final : public NodeDisk {
 public:
  explicit JournalDisk(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}
  std::unique_ptr<LogStore> open() override;
  void crash(Random& random) override;
  void wipe() override;

  std::size_t bytes() const { return file_.size(); }
  std::size_t durable_bytes() const { return durable_; }

 private:
  friend class JournalStore;
  std::size_t budget_bytes_;
  std::vector<std::uint8_t> file_;
  std::size_t durable_ = 0;  // of them
};

}  // namespace onemap::comms::sim
