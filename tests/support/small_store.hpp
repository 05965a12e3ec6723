#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "comms/disk/disk_store.hpp"

// A store that is full soon, and what tests of it ask again and again.
namespace onemap::test {

inline comms::DiskStoreConfig small(std::size_t budget = 1u << 20) {
  comms::DiskStoreConfig config;
  config.budget_bytes = budget;
  config.author_bytes = budget;
  config.segment_bytes = budget / 8;
  config.index_bytes = 64 * 8 * 50;
  config.cache_bytes = 4096;
  return config;
}
inline std::unique_ptr<comms::DiskStore> opened(comms::Disk& disk, const comms::DiskStoreConfig& config = small()) {
  auto store = comms::DiskStore::open(disk, config);
  return store ? std::move(*store) : nullptr;
}
inline std::vector<std::uint8_t> body(std::size_t bytes, std::uint8_t value = 7) {
  return std::vector<std::uint8_t>(bytes, value);
}
inline void expect_same(const Record& there, const std::shared_ptr<const Record>& here) {
  ASSERT_NE(here, nullptr);
  EXPECT_EQ(here->id, there.id);
  EXPECT_EQ(here->kind, there.kind);
  EXPECT_EQ(here->body, there.body);
  EXPECT_EQ(here->seal, there.seal);
  EXPECT_EQ(here->dropped, there.dropped);
}

}  // namespace onemap::test
