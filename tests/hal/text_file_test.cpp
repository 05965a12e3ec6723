#include "hal/base/text_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace onemap {
namespace {

using testing::HasSubstr;

TEST(TextFile, IsReadOrRefusedWithItsName) {
  const test::TempFolder folder;
  folder.write("small.txt", "fx 500\n");
  EXPECT_EQ(*read_text_file(folder / "small.txt"), "fx 500\n");
  folder.write("empty.txt", "");
  EXPECT_EQ(*read_text_file(folder / "empty.txt"), "");
  folder.write("full.txt", std::string(65536, '\n'));
  EXPECT_EQ(read_text_file(folder / "full.txt")->size(), 65536u);

  folder.write("large.txt", std::string(65537, '\n'));
  const std::pair<std::string, std::string> cases[] = {
      {"large.txt", "larger than 64 KiB"}, {"none.txt", "No such file"}, {"", "cannot be read"}};
  for (const auto& [name, why] : cases) {
    const auto refused = read_text_file(folder / name);
    ASSERT_FALSE(refused.ok()) << name;
    EXPECT_THAT(refused.error().text(), testing::AllOf(HasSubstr(folder / name), HasSubstr(why)));
  }
}

}  // namespace
}  // namespace onemap
