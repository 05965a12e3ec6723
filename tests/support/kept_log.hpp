#pragma once
// A log on a disk, as a robot keeps it in OUT/log, written and read by a test.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"

namespace onemap::test {

template <class T>
T taken(Result<T> result) {
  return std::move(*result);
}

struct Kept {
  std::unique_ptr<comms::PosixDisk> disk;
  std::unique_ptr<comms::DiskStore> store;
  explicit Kept(const std::string& folder)
      : disk(taken(comms::PosixDisk::open(folder))), store(taken(comms::DiskStore::open(*disk, {}))) {}
  void append(const Record& record) { ASSERT_TRUE(store->append(record)) << record.id.seq; }
};

}  // namespace onemap::test
