#include "render/file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "temporary_folder.hpp"

namespace onemap::render {
namespace {

std::vector<std::uint8_t> bytes(std::size_t size, std::uint8_t value) { return std::vector<std::uint8_t>(size, value); }

TEST(File, comes_back_as_written_and_is_replaced_whole) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "a.bin";
  for (const auto& content : {bytes(3'000'000, 7), bytes(5, 9), bytes(0, 0)}) {
    ASSERT_TRUE(write_file(path, content).ok());
    EXPECT_EQ(*read_file(path), content);
  }
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(File, an_error_names_the_path_and_the_reason) {
  const test::TemporaryFolder folder;
  const auto written = write_file(folder / "missing/a.bin", bytes(3, 1));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().place, folder / "missing/a.bin");
  EXPECT_NE(written.error().reason.find("No such file or directory"), std::string::npos);
  const auto read = read_file(folder / "nothing");
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().text().find("nothing: cannot read: No such file"), std::string::npos) << read.error().text();
  ASSERT_TRUE(std::filesystem::create_directory(folder / "full"));
  EXPECT_FALSE(write_file(folder / "full", bytes(3, 1)).ok());
  EXPECT_FALSE(read_file(folder / "full").ok());
  EXPECT_EQ(folder.entries(), 1u) << "a temporary file was left behind";
}

// A limit of the file size stands for a full disk: the write is cut short in the middle.
TEST(File, a_write_that_fails_half_way_leaves_the_old_file_and_no_rest) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "map.ply";
  ASSERT_TRUE(write_file(path, bytes(10, 1)).ok());
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{100'000, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto written = write_file(path, bytes(1'000'000, 2));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  (void)std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().reason.find("File too large"), std::string::npos) << written.error().text();
  EXPECT_EQ(*read_file(path), bytes(10, 1));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(File, what_a_killed_writer_left_does_not_stop_the_next) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.bin.partial0") << "rest";
  ASSERT_TRUE(write_file(folder / "a.bin", bytes(4, 4)).ok());
  EXPECT_EQ(*read_file(folder / "a.bin"), bytes(4, 4));
}

}  // namespace
}  // namespace onemap::render
