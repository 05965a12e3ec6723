#include "daemon/memory_limit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kMB = 1u << 20;

// A machine of 1000 MB as its files tell it.
class Machine : public testing::Test {
 protected:
  void SetUp() override { root_.write("proc/meminfo", "MemFree: 1 kB\nMemTotal:       1024000 kB\n"); }
  MemoryLimit limit() const { return memory_limit(root_.path()); }
  const test::TempFolder root_;
};

TEST_F(Machine, HasItsMemory) {
  EXPECT_EQ(limit().bytes, 1000 * kMB);
  EXPECT_EQ(limit().what, "this machine has");
}

TEST_F(Machine, GroupsOfVersion2LimitWhatIsBelowThem) {
  root_.write("proc/self/cgroup", "0::/robots/left.service\n");
  root_.write("sys/fs/cgroup/robots/left.service/memory.max", "max\n");
  EXPECT_EQ(limit().bytes, 1000 * kMB);
  root_.write("sys/fs/cgroup/robots/memory.max", std::to_string(300 * kMB) + "\n");
  EXPECT_EQ(limit().bytes, 300 * kMB);
  EXPECT_THAT(limit().what, HasSubstr("control group"));
  root_.write("sys/fs/cgroup/robots/left.service/memory.max", std::to_string(200 * kMB) + "\n");
  EXPECT_EQ(limit().bytes, 200 * kMB);
  root_.write("sys/fs/cgroup/memory.max", std::to_string(100 * kMB) + "\n");
  EXPECT_EQ(limit().bytes, 100 * kMB) << "a container's own group";
}

TEST_F(Machine, GroupsOfVersion1AreFoundByTheirController) {
  root_.write("proc/self/cgroup", "9:name=systemd:/\n4:cpu,memory:/host/path\n3:cpuset:/\n0::/\n");
  root_.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(limit().bytes, 1000 * kMB);
  root_.write("sys/fs/cgroup/memory/memory.limit_in_bytes", std::to_string(50 * kMB));
  EXPECT_EQ(limit().bytes, 50 * kMB);
  root_.write("sys/fs/cgroup/memory/host/path/memory.limit_in_bytes", std::to_string(40 * kMB));
  EXPECT_EQ(limit().bytes, 40 * kMB);
}

TEST_F(Machine, WhatCannotBeReadLimitsNothing) {
  root_.write("proc/self/cgroup", "nonsense\n0:\n0::/../..\n");
  root_.write("sys/fs/cgroup/memory.max", "soon\n");
  EXPECT_EQ(limit().bytes, 1000 * kMB);
  root_.write("proc/meminfo", "MemTotal: much\n");
  EXPECT_EQ(limit().bytes, UINT64_MAX);
}

TEST(MemoryLimit, ThisMachineHasSome) {
  EXPECT_GT(memory_limit().bytes, 64 * kMB);
  EXPECT_LT(memory_limit().bytes, UINT64_MAX);
}

TEST(CheckMemory, CountsAllBudgets) {
  Config config;
  config.mapper.map.budget_bytes = 48 * kMB;
  config.global_budget_bytes = 64 * kMB;
  config.store_budget_bytes = 256 * kMB;
  EXPECT_TRUE(check_memory(config, {368 * kMB, "it has"}).ok());
  EXPECT_EQ(
      check_memory(config, {367 * kMB, "it has"}).error().text(),
      "map.budget_mb + map.global_budget_mb + network.store_budget_mb: 48 + 64 + 256 = 368 MB, but it has 367 MB");
}

}  // namespace
}  // namespace onemap::daemon
