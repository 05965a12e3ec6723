#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include "comms/frontier.hpp"
#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/record_head.hpp"
#include "comms/wire.hpp"
#include "sim_net.hpp"

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
  EXPECT_GT(store.used(), 90'000u - 1000 - MemoryStore::kRecordBytes);
  while (store.append(record(1, poses, 1000))) ++poses;
  EXPECT_GE(poses, 7u);
  EXPECT_LE(store.used(), store.capacity());
  EXPECT_EQ(store.frontier().at(record(3, 0, 0).id.log), voxels);
}

TEST(MemoryStore, WhatOnlyNamesANeedlessRecordHasRoom) {
  MemoryStore store(100'000);
  std::uint32_t voxels = 0;
  while (store.append(record(3, voxels, 1000))) ++voxels;
  for (const std::size_t bytes : {1000, 30}) {
    Record names = record(3, voxels, bytes);
    names.seal.replaces = 0;
    EXPECT_EQ(store.append(names).ok(), bytes == 30) << "it makes room";
  }
}

TEST(MemoryStore, SaysWhyItRefuses) {
  MemoryStore store(10'000);
  EXPECT_THAT(store.append(record(1, 3, 10)).error().text(), testing::HasSubstr("3 is not the next, which is 0"));
  ASSERT_TRUE(store.append(record(1, 0, 5000)));
  const auto refused = store.append(record(3, 0, 6000));
  ASSERT_FALSE(refused);
  for (const char* words : {"store is full", "of 10000 bytes", "network.store_budget_mb", "6000 bytes"})
    EXPECT_THAT(refused.error().text(), testing::HasSubstr(words));
}

TEST(MemoryStore, ScansInOrderAndForgetsBodies) {
  MemoryStore store(100'000);
  ASSERT_TRUE(store.sync());
  for (std::uint32_t k = 0; k < 3; ++k) {
    ASSERT_TRUE(store.append(record(2, k, 1000)));
    ASSERT_TRUE(store.append(record(1, k, 1000)));
  }
  const VersionVector frontier = store.frontier();
  const std::size_t used = store.used();
  EXPECT_TRUE(store.forget(record(1, 1, 0).id));
  EXPECT_FALSE(store.forget(record(1, 1, 0).id));
  EXPECT_FALSE(store.forget(record(1, 3, 0).id));
  const auto head = store.find(record(1, 1, 0).id);
  ASSERT_NE(head, nullptr);
  EXPECT_TRUE(head->body.empty());
  EXPECT_EQ(head->dropped, (DroppedBody{1000, digest_of(record(1, 1, 1000).body)}));
  EXPECT_EQ(hash_of(head_of(*head)), hash_of(head_of(record(1, 1, 1000))));
  EXPECT_EQ(store.frontier(), frontier);
  EXPECT_EQ(store.used(), used - 1000);
  EXPECT_TRUE(store.append(record(1, 3, 10))) << "its place stays taken";
  std::vector<RecordId> seen;
  store.scan([&](const auto& one) { seen.push_back(one->id); });
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.size(), 7u);
}

// What glibc gives out for a node with a store, two living neighbours that hold the same, and nothing else to do.
std::size_t cost_of(std::size_t logs, std::size_t records, std::size_t bytes) {
  sim::SimNet net(1, {});
  NodeConfig config;
  config.max_robots = 20'000, config.max_logs = 20'000;
  net.add_team(3, sim::complete(3), config);
  net.run_for(std::chrono::seconds(1));
  const std::size_t before = mallinfo2().uordblks, charged = net[0].store->bytes();
  for (std::size_t k = 0; k < logs; ++k)
    for (std::uint32_t seq = 0; seq < records; ++seq)
      if (!net[0].store->append({{{sim::numbered("r", k), 1, 1}, seq}, 1, std::vector<std::uint8_t>(bytes), {}, {}}))
        return 0;
  return 100 * (mallinfo2().uordblks - before) / (net[0].store->bytes() - charged);
}

// In per cent of what is charged.
TEST(MemoryStore, ChargesWhatRecordsCost) {
  if (cost_of(1, 1, 100'000) == 0) GTEST_SKIP() << "no glibc allocator to ask";
  EXPECT_LE(cost_of(4000, 1, 0), 100u);
  EXPECT_LE(cost_of(1, 4000, 0), 100u);
  EXPECT_GE(cost_of(1, 4000, 0), 60u);
  EXPECT_LE(cost_of(100, 50, 300), 100u);
  EXPECT_LE(cost_of(10, 10, 50'000), 101u);
}

// Bytes a one-record log, beside its body. What a Node remembers of it is in the node's own block.
TEST(MemoryStore, ChargesWhatLogsCost) {
  const auto grown = [](std::size_t robots) {
    sim::SimNet net(1, {});
    NodeConfig config;
    config.bytes_per_second = 1'000'000'000;
    net.add_team(3, sim::complete(3), config);
    for (std::size_t k = 0; k < robots; ++k)
      if (!net[0].store->append(sim::SignedLogs().next({sim::numbered("r", k), 1, 1}, 1, {}))) return std::size_t{0};
    net.restart_node(0);
    const std::size_t before = mallinfo2().uordblks;
    net.run_until([&] { return net.equal(); }, std::chrono::seconds(60));
    net.run_for(std::chrono::seconds(10));
    for (std::size_t i = 0; i < 3; ++i) net[i].applied.clear();
    return (mallinfo2().uordblks - before) / 2;  // two nodes have got everything
  };
  const std::size_t few = grown(100), many = grown(900);
  if (many == 0) GTEST_SKIP() << "no glibc allocator to ask";
  const std::size_t each = (many - few) / 800;
  printf("a log of one empty record costs %zu bytes\n", each);
  EXPECT_LE(each, MemoryStore::kLogBytes + MemoryStore::kRecordBytes);
  EXPECT_GE(each, (MemoryStore::kLogBytes + MemoryStore::kRecordBytes) / 2);
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
