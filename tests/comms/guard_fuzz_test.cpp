// The corpus of the Guard's fuzzer as an ordinary test, and scripts at random.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/guard.hpp"
#include "hal/base/file.hpp"
#include "support/random.hpp"

namespace onemap {
namespace {

TEST(GuardFuzz, TheCorpus) {
  std::size_t played = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ONEMAP_SOURCE_DIR "/tests/fuzz/corpus/guard")) {
    const auto bytes = read_file(entry.path().string());
    ASSERT_TRUE(bytes.ok()) << entry.path();
    fuzz::fuzz_guard(bytes->data(), bytes->size());
    ++played;
  }
  EXPECT_GE(played, 5u);
}

TEST(GuardFuzz, ScriptsAtRandom) {
  test::Random random(11);
  for (int i = 0; i < 400; ++i) {
    std::vector<std::uint8_t> script(static_cast<std::size_t>(random.integer(1, 300)));
    for (auto& byte : script) byte = static_cast<std::uint8_t>(random.next() >> 50);
    if (i % 2 == 0) {  // let a session be made first
      const std::uint8_t begin[] = {1, 0, 0, 0, 2, 0, 0, 0};
      script.insert(script.begin(), std::begin(begin), std::end(begin));
    }
    fuzz::fuzz_guard(script.data(), script.size());
  }
}

}  // namespace
}  // namespace onemap
