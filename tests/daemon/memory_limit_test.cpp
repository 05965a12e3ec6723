#include "daemon/memory_limit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/capture.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

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

TEST(CheckMemory, CountsAllBudgetsAndTheTeamsMapTwice) {
  Config config;
  config.mapper.map.budget_bytes = 48 * kMB;
  config.global_budget_bytes = 64 * kMB;
  config.places_budget_bytes = 16 * kMB;
  config.plan.space.budget_bytes = 8 * kMB;
  config.store_budget_bytes = 256 * kMB;
  EXPECT_TRUE(check_memory(config, {456 * kMB, "it has"}).ok());
  EXPECT_EQ(check_memory(config, {455 * kMB, "it has"}).error().text(),
            "map.budget_mb + 2 * map.global_budget_mb + map.places_budget_mb + map.plan_budget_mb + "
            "network.store_budget_mb: 48 + 2 * 64 + 16 + 8 + 256 = 456 MB, but it has 455 MB");
  hal::Intrinsics hd;
  hd.width = 1280, hd.height = 720;  // five frames of 4.4 MB
  const std::uint64_t frames = Capture::bytes_of(hd);
  EXPECT_EQ(frames >> 20, 21u);
  EXPECT_TRUE(check_memory(config, {478 * kMB, "it has"}, frames).ok());
  EXPECT_THAT(
      check_memory(config, {477 * kMB, "it has"}, frames).error().text(),
      testing::AllOf(HasSubstr("network.store_budget_mb + the camera's frames: 48 + 2 * 64 + 16 + 8 + 256 + 21"),
                     HasSubstr("but it has 477 MB")));
}

// What the units allow has room for the budgets that hold when nobody says any, and twice, for a drawing.
TEST(CheckMemory, TheServicesLimitHasRoomForTheDefaults) {
  const std::string unit = test::text_of(std::filesystem::path(ONEMAP_SOURCE_DIR) / "systemd/common.in");
  const std::string begin = "\nMemoryMax=";
  const std::size_t at = unit.find(begin);
  ASSERT_NE(at, std::string::npos);
  std::size_t digits = 0;
  const std::string value = unit.substr(at + begin.size());
  const std::uint64_t most = std::stoull(value, &digits) * kMB;
  ASSERT_EQ(value[digits], 'M') << "mebibytes, as systemd reads them";
  const Status fits = check_memory(Config(), {most / 2, "half of MemoryMax="});
  EXPECT_TRUE(fits.ok()) << fits.error().text();
  Config config;
  config.global_budget_bytes = most / 2;
  EXPECT_FALSE(check_memory(config, {most, "MemoryMax="}).ok()) << "as systemd/common.in says";
}

}  // namespace
}  // namespace onemap::daemon
