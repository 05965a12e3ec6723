#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/fleet/child_process.hpp"
#include "support/patience.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::test {

inline nlohmann::json read_json(const std::filesystem::path& file) {
  auto json = nlohmann::json::parse(text_of(file), nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << file << " is missing or broken";
  return json;
}

inline std::size_t lines(const std::filesystem::path& file) { return lines_of(file).size(); }

// One of our programs, running; its outputs go to a log file.
inline daemon::ChildProcess start(const std::string& program, const std::vector<std::string>& arguments,
                                  const std::filesystem::path& log) {
  auto child = daemon::ChildProcess::start(std::string(ONEMAP_BIN_DIR) + "/" + program, arguments, log.string());
  if (!child) throw std::runtime_error(child.error().text());
  return std::move(*child);
}

// Runs a program to its end; what it exited with. -1: not within the time (times our patience).
inline int run(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& log,
               std::chrono::seconds limit = std::chrono::seconds(240)) {
  auto child = start(program, arguments, log);
  return child.wait(kPatience * limit) ? child.exit_code() : -1;
}

}  // namespace onemap::test
