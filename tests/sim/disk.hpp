#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

#include "comms/disk/disk_store.hpp"
#include "comms/log_store.hpp"
#include "support/memory_disk.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

using test::Random;

// What a robot's records lie on, beyond the life of a process. A store is open at most once, and closed before a crash
// is over.
class NodeDisk {
 public:
  virtual ~NodeDisk() = default;
  virtual std::unique_ptr<LogStore> open() = 0;
  virtual void die() {}  // before the store is closed: the process writes nothing more
  // The power went: what was synced stays, and of the rest as much as chance leaves.
  virtual void crash(Random& random) = 0;
  virtual void wipe() = 0;
  virtual void fill(bool /*full*/) {}          // somebody else took all the room that there was, or gave it back
  virtual bool works() const { return true; }  // while it is open: what is told now is kept
};

// No disk: records live in memory and die with the process.
class NoDisk final : public NodeDisk {
 public:
  explicit NoDisk(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}
  std::unique_ptr<LogStore> open() override;
  void crash(Random&) override {}
  void wipe() override {}

 private:
  std::size_t budget_bytes_;
};

// The daemon's own log (DiskStore) on a disk in memory that loses, tears and fills up. A sync takes its time: it has
// ended when it was asked so often whether it has.
class LogDisk final : public NodeDisk {
 public:
  LogDisk(std::size_t budget_bytes, unsigned polls_of_a_sync);
  ~LogDisk() override;
  std::unique_ptr<LogStore> open() override;
  void die() override;
  void crash(Random& random) override;
  void wipe() override;
  void fill(bool full) override;
  bool works() const override;

  MemoryDisk& disk() { return disk_; }

 private:
  class Late;
  std::size_t budget_bytes_;
  MemoryDisk disk_;
  std::unique_ptr<Late> late_;
  const DiskStore* store_ = nullptr;  // that was opened last
};

}  // namespace onemap::comms::sim
