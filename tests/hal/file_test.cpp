#include "hal/base/file.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <functional>
#include <thread>

#include "support/temp_folder.hpp"

namespace {

// What fsync() was called for, in order: the path, and whether the file under test was in place then.
struct Synced {
  std::string path;
  bool in_place;
};
std::vector<Synced> synced;
std::string watched;
int sync_error = 0;

}  // namespace

// In front of the C library's.
extern "C" int fsync(int fd) {
  std::error_code none;
  const auto path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd), none);
  synced.push_back({path.string(), std::filesystem::exists(watched, none)});
  if (sync_error != 0) return errno = sync_error, -1;
  return static_cast<int>(syscall(SYS_fsync, fd));
}

namespace onemap {
namespace {

std::vector<std::uint8_t> bytes(std::size_t size, std::uint8_t value) { return std::vector<std::uint8_t>(size, value); }

TEST(File, comes_back_as_written_and_is_replaced_whole) {
  const test::TempFolder folder;
  const std::string path = folder / "a.bin";
  for (const auto& content : {bytes(3'000'000, 7), bytes(5, 9), bytes(0, 0)}) {
    ASSERT_TRUE(write_file(path, content).ok());
    EXPECT_EQ(*read_file(path), content);
  }
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(File, an_error_names_the_path_and_the_reason) {
  const test::TempFolder folder;
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

TEST(File, what_is_larger_than_it_should_be_is_refused) {
  const test::TempFolder folder;
  folder.write("full", std::string(4096, '\n'));
  EXPECT_EQ(read_text_file(folder / "full", 4096)->size(), 4096u);
  EXPECT_EQ(read_file(folder / "full", 4096)->size(), 4096u);
  folder.write("large", std::string(4097, '\n'));
  EXPECT_EQ(read_text_file(folder / "large", 4096).error().text(),
            folder / "large" + ": cannot read: larger than 4 KiB");
  EXPECT_EQ(read_file(folder / "large", 4096).error().reason, "cannot read: larger than 4 KiB");
  EXPECT_EQ(read_text_file("/proc/self/status", 16 << 10).value().substr(0, 5), "Name:") << "says that it is empty";
  EXPECT_FALSE(read_text_file("/proc/self/status", 16).ok());
}

TEST(File, memory_is_used_again_and_only_regular_files_come_into_it) {
  const test::TempFolder folder;
  folder.write("a", std::string(100'000, 'a'));
  folder.write("b", "b");
  std::vector<std::uint8_t> into;
  ASSERT_TRUE(read_regular_file(folder / "a", into, kAnySize).ok());
  EXPECT_EQ(into, bytes(100'000, 'a'));
  const auto* const memory = into.data();
  ASSERT_TRUE(read_regular_file(folder / "b", into, kAnySize).ok());
  EXPECT_EQ(into, bytes(1, 'b'));
  ASSERT_TRUE(read_regular_file(folder / "a", into, 100'000).ok());
  EXPECT_EQ(into.data(), memory);
  EXPECT_EQ(read_regular_file(folder / "a", into, 99'999).error().reason, "cannot read: larger than 97 KiB");
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0666), 0);
  for (const std::string& path : {folder / "fifo", folder / ""}) {
    const auto refused = read_regular_file(path, into, kAnySize);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().text(), path + ": cannot read: not a regular file");
  }
}

// A limit of the file size stands for a full disk: the write is cut short in the middle.
TEST(File, a_write_that_fails_half_way_leaves_the_old_file_and_no_rest) {
  const test::TempFolder folder;
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

TEST(File, what_killed_writers_left_is_used_again) {
  const test::TempFolder folder;
  std::ofstream(folder / "a.bin.partial0") << "a longer rest";
  for (std::uint8_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(write_file(folder / "a.bin", bytes(4, i)).ok());
    EXPECT_EQ(*read_file(folder / "a.bin"), bytes(4, i));
    EXPECT_EQ(folder.entries(), 1u);
  }
}

TEST(File, what_stands_in_the_way_of_the_temporary_file_is_left_alone) {
  const test::TempFolder folder;
  std::ofstream(folder / "other") << "other";
  std::filesystem::create_directory(folder / "a.bin.partial0");
  std::filesystem::create_symlink(folder / "other", folder / "a.bin.partial1");
  ASSERT_EQ(mkfifo((folder / "a.bin.partial2").c_str(), 0666), 0);
  ASSERT_TRUE(write_file(folder / "a.bin", bytes(4, 4)).ok());
  EXPECT_EQ(*read_file(folder / "a.bin"), bytes(4, 4));
  EXPECT_EQ(read_file(folder / "other")->size(), 5u);
  EXPECT_EQ(folder.entries(), 5u);
}

TEST(File, writers_at_once_do_not_mix) {
  const test::TempFolder folder;
  const std::string path = folder / "a.bin";
  std::vector<std::thread> writers;
  std::atomic<int> failed = 0;
  for (std::uint8_t w = 1; w <= 4; ++w)
    writers.emplace_back([&, w] {
      for (int i = 0; i < 60; ++i) failed += write_file(path, bytes(20'000u + w, w), Durable::no).ok() ? 0 : 1;
    });
  for (int i = 0; i < 100; ++i) {
    const auto now = read_file(path);
    if (now && !now->empty()) {
      EXPECT_EQ(*now, bytes(20'000u + now->front(), now->front()));
    }
  }
  for (auto& writer : writers) writer.join();
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(File, is_on_the_disk_before_it_has_the_name_and_the_name_after) {
  const test::TempFolder folder;
  watched = folder / "a.bin";
  synced.clear();
  ASSERT_TRUE(write_file(watched, bytes(4, 4)).ok());
  ASSERT_EQ(synced.size(), 2u);
  EXPECT_EQ(synced[0].path, watched + ".partial0");
  EXPECT_FALSE(synced[0].in_place);
  EXPECT_EQ(synced[1].path + "/a.bin", watched);
  EXPECT_TRUE(synced[1].in_place);
  synced.clear();
  ASSERT_TRUE(write_file(watched, bytes(4, 5), Durable::no).ok());
  EXPECT_TRUE(synced.empty()) << "what is written four times a second is not synced";
  EXPECT_EQ(*read_file(watched), bytes(4, 5));
}

TEST(File, a_disk_that_fails_to_sync_is_an_error_and_the_old_file_stays) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_file(folder / "a.bin", bytes(4, 4)).ok());
  sync_error = EIO;
  const auto written = write_file(folder / "a.bin", bytes(4, 5));
  sync_error = 0;
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().reason, "cannot sync to the disk: Input/output error");
  EXPECT_EQ(*read_file(folder / "a.bin"), bytes(4, 4));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(File, only_regular_files_are_replaced) {
  const test::TempFolder folder;
  std::filesystem::create_directory(folder / "sub");
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0666), 0);
  const std::vector<std::pair<std::string, std::string>> wrong{{"", "the path is empty"},
                                                               {folder / "sub", "is a folder"},
                                                               {folder / "sub/", "ends in '/'"},
                                                               {folder / "new/", "ends in '/'"},
                                                               {folder / ".", "is a folder"},
                                                               {"/", "ends in '/'"},
                                                               {folder / "fifo", "not a regular file"},
                                                               {folder / "fifo/a.bin", "fifo': Not a directory"},
                                                               {folder / "none/a.bin", "none': No such file"},
                                                               {folder / std::string(300, 'x'), "name too long"}};
  for (const auto& [path, why] : wrong) {
    const auto written = write_file(path, bytes(3, 1));
    ASSERT_FALSE(written.ok()) << path;
    EXPECT_EQ(written.error().place, path);
    EXPECT_NE(written.error().reason.find(why), std::string::npos) << written.error().text();
  }
  EXPECT_EQ(folder.entries(), 2u);
}

// Runs in a process with a file system of its own, 64 KiB large, at the folder; what it returns is the exit status.
constexpr int kNoMount = 77;
int on_a_small_disk(const std::string& at, const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    const bool mounted = unshare(CLONE_NEWNS) == 0 && mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                         mount("tmpfs", at.c_str(), "tmpfs", 0, "size=64k") == 0;
    _exit(mounted ? body() : kNoMount);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(File, a_full_disk_is_said_and_leaves_the_old_file) {
  const test::TempFolder folder;
  const std::string path = folder / "a.bin";
  const int result = on_a_small_disk(folder / "", [&] {
    if (!write_file(path, bytes(100, 1)).ok()) return 1;
    const auto written = write_file(path, bytes(1'000'000, 2));
    if (written.ok() || written.error().text() != path + ": cannot write: No space left on device") return 2;
    if (*read_file(path) != bytes(100, 1)) return 3;
    if (folder.entries() != 1) return 4;
    return write_file(path, bytes(100, 3)).ok() && *read_file(path) == bytes(100, 3) ? 0 : 5;
  });
  if (result == kNoMount) GTEST_SKIP() << "no file system can be mounted here (needs root)";
  EXPECT_EQ(result, 0);
}

TEST(File, a_folder_that_cannot_be_written_to_is_said) {
  const test::TempFolder folder;
  const std::string path = folder / "a.bin";
  const int result = on_a_small_disk(folder / "", [&] {
    if (!write_file(path, bytes(100, 1)).ok()) return 1;
    if (mount(nullptr, (folder / "").c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) != 0) return kNoMount;
    const auto written = write_file(path, bytes(100, 2));
    if (written.ok() || written.error().text() != path + ": cannot write: Read-only file system") return 2;
    return *read_file(path) == bytes(100, 1) ? 0 : 3;
  });
  if (result == kNoMount) GTEST_SKIP() << "no file system can be mounted here (needs root)";
  EXPECT_EQ(result, 0);
}

}  // namespace
}  // namespace onemap
