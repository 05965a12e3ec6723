#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/fleet/child_process.hpp"

namespace onemap::test {

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline nlohmann::json read_json(const std::filesystem::path& file) {
  auto json = nlohmann::json::parse(read_text(file), nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << file << " is missing or broken";
  return json;
}

inline std::size_t lines(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// A folder of a test's own, gone after it.
class Folder {
 public:
  Folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            ("onemap_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::string text() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

// One of our programs, running; its outputs go to a log file.
inline daemon::ChildProcess start(const std::string& program, const std::vector<std::string>& arguments,
                                  const std::filesystem::path& log) {
  auto child = daemon::ChildProcess::start(std::string(ONEMAP_BIN_DIR) + "/" + program, arguments, log.string());
  if (!child) throw std::runtime_error(child.error().text());
  return std::move(*child);
}

// Runs a program to its end; what it exited with. -1: not within the time.
inline int run(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& log,
               std::chrono::seconds limit = std::chrono::seconds(240)) {
  auto child = start(program, arguments, log);
  return child.wait(limit) ? child.exit_code() : -1;
}

}  // namespace onemap::test
