// The house rules that a compiler does not check: pure modules stay pure, includes go down, files and folders are where
// ARCHITECTURE.md says.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/text_of.hpp"

namespace {

namespace fs = std::filesystem;
const fs::path kRoot = ONEMAP_SOURCE_DIR;

std::vector<fs::path> sources(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
    if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

// Lines of the file that match, as "file:line: text".
std::vector<std::string> matches(const fs::path& path, const std::regex& what) {
  std::vector<std::string> out;
  int number = 0;
  for (const std::string& line : onemap::test::lines_of(path))
    if (++number; std::regex_search(line, what))
      out.push_back(fs::relative(path, kRoot).string() + ":" + std::to_string(number) + ": " + line);
  return out;
}

std::string offences(const std::vector<std::string>& folders, const std::string& pattern,
                     const std::string& except = "") {
  std::string all;
  const std::regex what(pattern);
  for (const auto& folder : folders)
    for (const auto& path : sources(folder)) {
      if (!except.empty() && std::regex_search(path.string(), std::regex(except))) continue;
      for (const auto& hit : matches(path, what)) all += hit + "\n";
    }
  return all;
}

TEST(Architecture, TheScannerSeesOffences) {
  EXPECT_FALSE(offences({"daemon"}, R"(#include <thread>|#include <chrono>)").empty())
      << "the daemon has threads: the scan must find them";
}

TEST(Architecture, PureModulesHaveNoThreadsClocksSocketsFilesOrOutput) {
  const std::string forbidden =
      R"(#include <(thread|mutex|condition_variable|future|iostream|fstream|cstdio|filesystem|random|unordered_map|unordered_set|sys/|netinet/|arpa/|poll\.h|unistd\.h|time\.h))"
      R"(|#include "hal/base/file\.hpp"|(steady_clock|system_clock|high_resolution_clock)::now|std::rand\b|\bprintf\()";
  EXPECT_EQ(offences({"mapping"}, forbidden), "");
  EXPECT_EQ(offences({"comms"}, forbidden, "comms/(udp|disk)/"), "");
}

TEST(Architecture, ImagingIsPureAndKnowsNoBackend) {
  EXPECT_EQ(
      offences(
          {"hal/imaging"},
          R"(#include <(thread|mutex|condition_variable|iostream|fstream|filesystem|sys/|fcntl\.h|poll\.h|unistd\.h|time\.h))"
          R"(|#include "hal/(backends/|base/file\.hpp)|\bprintf\()"),
      "");
}

TEST(Architecture, OnlyTheDaemonReadsAClock) {
  EXPECT_EQ(offences({"hal", "mapping", "comms", "render"},
                     R"((steady_clock|system_clock|high_resolution_clock)::now|clock_gettime|gettimeofday)"),
            "");
}

TEST(Architecture, SocketsBetweenRobotsAreOpenedInOnePlace) {
  EXPECT_EQ(offences({"hal", "mapping", "render"}, R"(#include <(sys/socket\.h|netinet/))"), "");
}

TEST(Architecture, IncludesGoDown) {
  EXPECT_EQ(offences({"hal"}, R"(#include "(mapping|comms|render|daemon)/)"), "");
  EXPECT_EQ(offences({"mapping"}, R"(#include "(comms|render|daemon|hal/backends/)[/a-z])"), "");
  EXPECT_EQ(offences({"comms"}, R"(#include "(mapping|render|daemon|hal/backends/)[/a-z])"), "");
  EXPECT_EQ(offences({"render"}, R"(#include "(comms|daemon|hal/backends/)[/a-z])"), "");
  EXPECT_EQ(offences({"daemon/src", "daemon/include"}, R"(#include "evaluation/)"), "") << "no robot evaluates itself";
  EXPECT_EQ(offences({"daemon/evaluation"}, R"(#include "(mapping|comms|render|daemon)/)"), "");
  EXPECT_EQ(offences({"mapping/src/local", "mapping/include/mapping/local"}, R"(#include "mapping/team/)"), "")
      << "one robot's mapping does not know the team";
  EXPECT_EQ(offences({"mapping/src/records", "mapping/include/mapping/records"},
                     R"(#include "mapping/(team/|local/local_mapper))"),
            "")
      << "bodies of records know the values that they hold, and nobody who makes or reads them";
}

TEST(Architecture, NoLoopOverUnorderedContainersAndNoLibraryRandom) {
  EXPECT_EQ(offences({"hal", "mapping", "comms"},
                     R"(std::(mt19937|default_random_engine|uniform_\w+_distribution|normal_distribution))"),
            "");
}

TEST(Architecture, TopLevelFoldersAreTheOnesOfTheHouse) {
  const std::set<std::string> house{"daemon", "hal", "mapping", "comms", "render", "systemd", "tests",
                                    "build",  "out", ".git",    ".ci",   "debian", "share",   "examples"};
  for (const auto& entry : fs::directory_iterator(kRoot))
    if (entry.is_directory()) {
      EXPECT_TRUE(house.count(entry.path().filename().string())) << entry.path() << " is not a room of the house";
    }
}

TEST(Architecture, EveryFolderIsNamedInArchitectureMd) {
  const std::string text = onemap::test::text_of(kRoot / "ARCHITECTURE.md");
  for (const char* folder : {"hal", "hal/imaging", "hal/backends/replay", "hal/backends/simulated", "hal/backends/v4l2",
                             "mapping/local", "mapping/team", "comms", "comms/udp", "render", "daemon",
                             "daemon/control", "daemon/evaluation", "systemd", "tests"})
    EXPECT_NE(text.find(folder), std::string::npos) << folder;
}

TEST(Architecture, NoPathOfOneMachineAndNoFastMath) {
  const std::string forbidden = R"re((^|[^A-Za-z0-9_.])/(home|root|work)/|-march=native|-ffast-math)re";
  EXPECT_EQ(offences({"hal", "mapping", "comms", "render", "daemon"}, forbidden), "");
}

}  // namespace
