// A team's map beside the number of its robots: what each robot's team thread does and what it receives; the merge of
// all records, and one robot's next keyframe in a map that stands. Beside it the same frontier fused from nothing,
// which is what a map that is not incremental would cost.
//   bench_team [FRAMES [ROBOTS...]]      default: 150 frames each; 2 5 10 20 robots
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "mapping/local/surface.hpp"
#include "mapping/team/team_graph.hpp"
#include "support/team_robots.hpp"

namespace {

using namespace onemap;
using namespace onemap::mapping;

constexpr std::size_t kBudget = 256u << 20;

AtlasConfig large_map() {
  AtlasConfig out;
  out.map.budget_bytes = kBudget;
  return out;
}

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

std::vector<test::Author> explore_all(int robots, int frames) {
  std::vector<test::Author> out;
  for (int i = 1; i <= robots; ++i)
    out.push_back(test::explore(fmt::format("robot{:02}", i),
                                fmt::format("simulated:house?robot={}&robots={}&frames={}&seed=5", i, robots, frames)));
  return out;
}

std::size_t bytes_of(const test::Records& records) {
  std::size_t out = 0;
  for (const RecordPtr& record : records) out += record->body.size();
  return out;
}

// Until nobody has anything to say; the processor time of each robot's team.
std::vector<double> work(std::deque<test::Robot>& robots, test::Records& all) {
  std::vector<double> ms(robots.size());
  for (bool news = true; news;) {
    news = false;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const double before = cpu_ms();
      const test::Records said = robots[i].work();
      ms[i] += cpu_ms() - before;
      news = news || !said.empty();
      for (const RecordPtr& record : said) {
        all.push_back(record);
        for (std::size_t k = 0; k < robots.size(); ++k)
          if (k != i) robots[k].apply(record);
      }
    }
  }
  return ms;
}

struct Fused {
  double ms = 0;
  std::size_t submaps = 0;
};

Fused go(MapFusion& fusion, const TeamLog& log, const MapTarget& target) {
  const double before = cpu_ms();
  const std::uint64_t fused = fusion.submaps_fused();
  fusion.aim(log, target);
  while (fusion.underway()) fusion.step([] { return false; });
  const std::uint64_t digest = fusion.digest();
  return {cpu_ms() - before, digest == 0 ? 0 : fusion.submaps_fused() - fused};
}

// What is merged: the points of each robot's map by itself.
std::size_t points_apart(const TeamLog& log, const SolutionRecord& solution) {
  std::size_t out = 0;
  for (const ChainExtent& extent : everything_here(log, solution)) {
    MapFusion alone(kBudget);
    go(alone, log, {solution, {extent}});
    out += extract_mesh(*alone.map()).vertices.size();
  }
  return out;
}

// The records of one keyframe after the other, at the end of one robot's stream, into a map that has all others'.
void incremental(const TeamLog& log, const SolutionRecord& solution) {
  MapTarget target{solution, everything_here(log, solution)};
  ChainExtent& last = target.extents.back();
  const std::uint32_t submaps = last.submaps, steps = std::min(submaps, 40u);
  last.submaps = submaps - steps;
  MapFusion fusion(kBudget);
  go(fusion, log, target);
  std::vector<double> ms;
  for (std::uint32_t i = 0; i < steps; ++i) {
    ++target.extents.back().submaps;
    ms.push_back(go(fusion, log, target).ms);
  }
  MapFusion anew(kBudget);
  const Fused whole = go(anew, log, target);
  std::ranges::sort(ms);
  fmt::print("  all records: {} submaps, {} points of the robots by themselves, to {} blocks, {} points: {:.0f} ms\n",
             whole.submaps, points_apart(log, solution), anew.map()->used(), extract_mesh(*anew.map()).vertices.size(),
             whole.ms);
  fmt::print("  one record more: median {:.1f} ms, most {:.1f} ms: {:.3f} of fusing anew; equal bytes: {}\n",
             ms[ms.size() / 2], ms.back(), ms[ms.size() / 2] / whole.ms, fusion.digest() == anew.digest());
}

std::size_t anchors_of(const SolutionRecord& solution) {
  std::size_t out = 0;
  for (const SolvedRobot& robot : solution.robots) out += robot.anchors.size();
  return out;
}

// A solution that moves one anchor by two centimetres: its surface is taken out of the map and fused again.
void one_anchor_moves(const TeamLog& log, const SolutionRecord& solution) {
  MapTarget target{solution, everything_here(log, solution)};
  MapFusion fusion(kBudget);
  go(fusion, log, target);
  std::vector<double> ms;
  for (SolvedRobot& robot : target.solution.robots)
    for (std::size_t i = 0; i < std::min<std::size_t>(robot.anchors.size(), 8); ++i) {
      robot.anchors[i].T_map_anchor.t_10um[0] += 2000;
      ms.push_back(go(fusion, log, target).ms);
    }
  std::ranges::sort(ms);
  fmt::print("  one anchor moved by 2 cm: median {:.1f} ms, most {:.1f} ms\n", ms[ms.size() / 2], ms.back());
}

void measure(int count, int frames) {
  const std::vector<test::Author> authors = explore_all(count, frames);
  std::deque<test::Robot> robots;
  test::Records all;
  for (const test::Author& author : authors) {
    robots.emplace_back(author, Duration::zero(), large_map());
    all.insert(all.end(), author.written().begin(), author.written().end());
  }
  for (test::Robot& robot : robots) robot.apply(all);
  const std::vector<double> ms = work(robots, all);
  double mean = 0;
  for (const double m : ms) mean += m / static_cast<double>(ms.size());
  bool equal = true;
  for (const test::Robot& robot : robots) equal = equal && robot.view().digest == robots[0].view().digest;
  const double bytes = static_cast<double>(bytes_of(all));
  fmt::print(
      "{} robots: {} in the map, {} records of {:.1f} MB, {:.2f} MB received a robot; team work a robot: mean {:.0f} "
      "ms, "
      "most {:.0f} ms, {:.2f} ms a record; one digest: {}\n",
      count, robots[0].view().robots_in_map, all.size(), bytes * 1e-6, bytes * (1 - 1.0 / count) * 1e-6, mean,
      *std::ranges::max_element(ms), mean / static_cast<double>(all.size()), equal);
  const SolutionRecord* solution = robots[0].map().solution();
  if (solution == nullptr) return;
  const TeamLog& log = robots[0].map().log();
  const double before = cpu_ms();
  const SolutionRecord again = solve_team(log, log.chains());
  fmt::print("  the pose graph: {} anchors, {:.0f} ms\n", anchors_of(again), cpu_ms() - before);
  incremental(log, *solution);
  one_anchor_moves(log, *solution);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> counts;
  for (int i = 1; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (std::ranges::any_of(counts, [](int n) { return n < 1; })) {
    fmt::print(stderr, "usage: bench_team [FRAMES [ROBOTS...]]\n");
    return 2;
  }
  const int frames = counts.empty() ? 150 : counts.front();
  if (!counts.empty()) counts.erase(counts.begin());
  if (counts.empty()) counts = {2, 5, 10, 20};
  for (const int count : counts) measure(count, frames);
}
