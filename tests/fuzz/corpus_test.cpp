// The corpora of the fuzz targets as an ordinary test: each input, and each with some bytes changed. A target that
// finds a promise broken ends the process and says which.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/targets.hpp"
#include "hal/base/file.hpp"
#include "support/random.hpp"

namespace onemap::fuzz {
namespace {

class Corpus : public testing::TestWithParam<Target> {};

std::vector<std::uint8_t> changed(std::vector<std::uint8_t> bytes, test::Random& random) {
  for (std::size_t k = 1 + random.below(3); k > 0 && !bytes.empty(); --k)
    bytes[random.below(bytes.size())] = static_cast<std::uint8_t>(random.next());
  if (random.below(4) == 0) bytes.resize(random.below(bytes.size() + 1));
  return bytes;
}

TEST_P(Corpus, IsHandledWhateverItSays) {
  constexpr int kChanges = 20;
  const std::filesystem::path folder = std::filesystem::path(ONEMAP_SOURCE_DIR) / "tests/fuzz/corpus" / GetParam().name;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto bytes = read_file(entry.path(), 1u << 24);
    ASSERT_TRUE(bytes) << bytes.error().text();
    GetParam().run(*bytes);
    test::Random random(bytes->size());
    for (int k = 0; k < kChanges; ++k) GetParam().run(changed(*bytes, random));
    ++files;
  }
  EXPECT_GE(files, 3u) << folder;
}

INSTANTIATE_TEST_SUITE_P(Of, Corpus, testing::ValuesIn(targets()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace onemap::fuzz
