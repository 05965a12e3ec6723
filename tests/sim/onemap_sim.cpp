// Plays many seeds of simulated teams, and says of each that fails what the least of it is.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "sim/explore.hpp"
#include "sim/run.hpp"
#include "sim/signatures.hpp"

namespace {
using namespace onemap;
using namespace onemap::comms::sim;

constexpr std::string_view kHelp =
    "usage: onemap_sim [--seeds N] [--from SEED] [--robots N] [--long] [--show] [--trace] [--as-is]\n"
    "       onemap_sim --explore SECONDS [--robots N] [--from SEED]\n"
    "  --seeds N    so many scenarios (1000)\n"
    "  --from SEED  the first one's seed (1)\n"
    "  --robots N   exactly so many robots, instead of 2 to 6\n"
    "  --long       longer, with more faults and records\n"
    "  --show       what happens in each\n"
    "  --trace      every datagram of the least of what fails\n"
    "  --as-is      what fails is not made smaller\n"
    "  --explore S  nothing goes wrong; each of a hundred robots, who hear ten others each, tells every S seconds "
    "where\n"
    "               it is, for 30 s\n"
    "Exit status: 0 all is well, 1 a scenario failed, 2 wrong options.\n";

constexpr std::size_t kMostToShrink = 12;  // robots; with more it takes hours

struct Options {
  std::uint64_t seeds = 1000, from = 1;
  Size size;
  bool show = false, trace = false, as_is = false;
  std::uint64_t explore_every_s = 0;
};

bool read(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool takes_number = word == "--seeds" || word == "--from" || word == "--robots" || word == "--explore";
    char* end = nullptr;
    const std::uint64_t number = takes_number && i + 1 < argc ? std::strtoull(argv[++i], &end, 10) : 0;
    if (takes_number && (end == nullptr || *end != 0 || end == argv[i])) return false;
    if (word == "--seeds")
      options.seeds = number;
    else if (word == "--explore" && number > 0)
      options.explore_every_s = number;
    else if (word == "--from")
      options.from = number;
    else if (word == "--robots" && number >= 2 && number <= 1000)
      options.size.least_robots = options.size.most_robots = number;
    else if (word == "--long") {
      options.size.least = std::chrono::seconds(10), options.size.most = std::chrono::seconds(60);
      options.size.most_faults = 20, options.size.writes_of_robot = 40;
    } else if (word == "--show")
      options.show = true;
    else if (word == "--trace")
      options.trace = true;
    else if (word == "--as-is")
      options.as_is = true;
    else
      return false;
  }
  return true;
}

const Trace print_line = [](const std::string& line) { fmt::print("{}\n", line); };

double part(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

int explore_all(const Options& options) {
  Exploring team;
  team.every = std::chrono::seconds(options.explore_every_s);
  if (options.size.least_robots == options.size.most_robots) team.robots = options.size.most_robots;
  const Explored all = explore(team, options.from);
  fmt::print(
      "{} robots, a pose each every {} s: {} records, {} datagrams, {:.0f} bytes/s a robot; {:.1f} s in {:.1f} s, "
      "{:.1f} times real time; {} {:.3f} s after the last\n",
      team.robots, options.explore_every_s, all.records, all.datagrams,
      static_cast<double>(all.bytes) / static_cast<double>(team.robots) / to_seconds(all.simulated),
      to_seconds(all.simulated), all.real_s, to_seconds(all.simulated) / all.real_s, all.equal ? "equal" : "NOT equal",
      to_seconds(all.to_equal));
  return all.equal ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!read(argc, argv, options)) {
    fmt::print(stderr, "{}", kHelp);
    return 2;
  }
  const RememberSignatures remember;
  if (options.explore_every_s > 0) return explore_all(options);
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t failed = 0, datagrams = 0, looks = 0;
  Duration simulated{};
  std::vector<double> recovery;
  for (std::uint64_t seed = options.from; seed < options.from + options.seeds; ++seed) {
    const Scenario scenario = scenario_of(seed, options.size);
    if (options.show) fmt::print("{}", text_of(scenario));
    const Outcome outcome = run(scenario);
    datagrams += outcome.datagrams, looks += outcome.looks, simulated += outcome.time;
    recovery.push_back(to_seconds(outcome.recovery));
    if (outcome.failure.empty()) continue;
    ++failed;
    fmt::print("FAILED {}  {}\n", text_of(scenario), outcome.failure);
    if (scenario.robots > kMostToShrink) continue;
    const Scenario least = options.as_is ? scenario : shrink(scenario);
    fmt::print("the least of it that fails: {}  {}\n\n", text_of(least),
               run(least, options.trace ? print_line : Trace{}).failure);
    std::fflush(stdout);
  }
  const double real = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print(
      "{} of {} scenarios failed; {} datagrams, {} looks at invariants; {:.0f} s in {:.1f} s, {:.0f} times real time\n"
      "from peace to equal: median {:.3f} s, 99 % {:.3f} s, most {:.3f} s\n",
      failed, options.seeds, datagrams, looks, to_seconds(simulated), real, to_seconds(simulated) / real,
      part(recovery, 0.5), part(recovery, 0.99), part(recovery, 1.0));
  return failed == 0 ? 0 : 1;
}
