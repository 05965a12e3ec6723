#include "hal/base/large_pages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace onemap {
namespace {

// What the kernel says of the mapping that holds this address: two letters a property.
std::string flags_of(const void* address) {
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/smaps");
  bool here = false;
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t from = 0, to = 0;
    char dash = 0;
    if (std::istringstream(line) >> std::hex >> from >> dash >> to && dash == '-') here = from <= wanted && wanted < to;
    if (here && line.starts_with("VmFlags:")) return line;
  }
  return "";
}

TEST(LargePages, AreAskedForAndTheMemoryIsTheSame) {
  std::vector<std::uint8_t> memory(8 << 20, 7);
  const std::uint8_t* const middle = memory.data() + memory.size() / 2;
  const std::string before = flags_of(middle);
  want_large_pages(memory.data() + 3, memory.size() - 5);
  EXPECT_TRUE(std::ranges::all_of(memory, [](std::uint8_t byte) { return byte == 7; }));
  if (!std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled") || before.empty())
    GTEST_SKIP() << "this kernel has no large pages, or does not say";
  EXPECT_EQ(before.find(" hg"), std::string::npos) << before;
  EXPECT_NE(flags_of(middle).find(" hg"), std::string::npos) << flags_of(middle);
}

TEST(LargePages, OfLittleOrNothingAreNoMatter) {
  std::uint8_t byte = 9;
  want_large_pages(nullptr, 0);
  want_large_pages(&byte, 1);
  EXPECT_EQ(byte, 9);
}

}  // namespace
}  // namespace onemap
