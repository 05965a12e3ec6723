#include <gtest/gtest.h>

#include "comms/frontier.hpp"
#include "comms/memory_store.hpp"
#include "comms/wire.hpp"

namespace onemap::comms {
namespace {

Record record(std::uint8_t lane, std::uint32_t seq, std::size_t bytes) {
  return {{{RobotId::from_name("a"), lane, 1}, seq}, 5, std::vector<std::uint8_t>(bytes, 9)};
}

TEST(MemoryStore, KeepsLogsInOrder) {
  MemoryStore store(10'000);
  EXPECT_FALSE(store.append(record(1, 1, 10)));
  EXPECT_TRUE(store.append(record(1, 0, 10)));
  EXPECT_FALSE(store.append(record(1, 0, 10)));
  EXPECT_TRUE(store.append(record(1, 1, 20)));
  EXPECT_TRUE(store.append(record(2, 0, 30)));
  EXPECT_EQ(store.refused_order(), 2u);
  EXPECT_EQ(store.frontier(), (VersionVector{{record(1, 0, 0).id.log, 2}, {record(2, 0, 0).id.log, 1}}));
  ASSERT_NE(store.find(record(1, 1, 0).id), nullptr);
  EXPECT_EQ(store.find(record(1, 1, 0).id)->body.size(), 20u);
  EXPECT_EQ(store.find(record(1, 2, 0).id), nullptr);
  EXPECT_EQ(store.find(record(0, 0, 0).id), nullptr);
}

TEST(MemoryStore, FullRefusesVoxelsFirst) {
  MemoryStore store(100'000);
  std::uint32_t voxels = 0, poses = 0;
  while (store.append(record(3, voxels, 1000))) ++voxels;
  EXPECT_LE(store.used(), 90'000u);
  EXPECT_GT(store.used(), 90'000u - 1000 - MemoryStore::kOverheadBytes);
  while (store.append(record(1, poses, 1000))) ++poses;
  EXPECT_GE(poses, 8u);
  EXPECT_LE(store.used(), store.capacity());
  EXPECT_EQ(store.refused_full(), 2u);
  EXPECT_EQ(store.frontier().at(record(3, 0, 0).id.log), voxels);
}

TEST(Digest, IsTheSumOfItsEntriesAndIgnoresEmptyLogs) {
  const LogId a{RobotId::from_name("a"), 1, 1}, b{RobotId::from_name("b"), 1, 1};
  EXPECT_EQ(digest({}), 0u);
  EXPECT_EQ(digest({{a, 3}, {b, 0}}), entry_digest(a, 3));
  EXPECT_EQ(digest({{a, 3}, {b, 4}}), entry_digest(a, 3) + entry_digest(b, 4));
  EXPECT_NE(entry_digest(a, 3), entry_digest(a, 4));
  EXPECT_NE(entry_digest(a, 3), entry_digest(b, 3));
  EXPECT_NE(entry_digest(a, 3), entry_digest({a.robot, 2, 1}, 3));
  EXPECT_NE(entry_digest(a, 3), entry_digest({a.robot, 1, 2}, 3));
}

}  // namespace
}  // namespace onemap::comms
