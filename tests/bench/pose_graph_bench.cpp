// A cold and a warm solve of simulated teams: three chains of 60 anchors, 40 right links, wrong ones beside them.
// Processor time of one thread. Says also what was kept. Run it on one core: taskset -c 0. Argument: number of seeds
// (20).
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <utility>
#include <vector>

#include "support/pose_graph_team.hpp"

using namespace onemap::mapping;
using onemap::test::PoseGraphTeam;

namespace {

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

struct Case {
  const char* name;
  int random, groups;  // wrong links; look-alike groups of six
  bool one_place;
};

void run(const Case& wrong, int seeds) {
  std::vector<double> cold, warm;
  int right = 0, kept_wrong = 0, misplaced = 0, in_map = 0, compared = 0;
  double worst = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    PoseGraphTeam team(1000 + static_cast<std::uint64_t>(seed));
    team.add_right_links(40);
    team.add_random_wrong_links(wrong.random);
    for (int i = 0; i < wrong.groups; ++i) team.add_look_alikes(6, wrong.one_place);
    const PoseGraph graph = team.graph();
    const double start = cpu_ms();
    const GraphSolution solution = graph.solve();
    const double between = cpu_ms();
    (void)graph.solve(&solution);
    cold.push_back(between - start);
    warm.push_back(cpu_ms() - between);
    right += team.used(solution, true);
    kept_wrong += team.used(solution, false);
    misplaced += team.misplaced_chains(solution);
    in_map += static_cast<int>(solution.components[0].chains.size());
    const GraphSolution clean = team.graph(true).solve();
    if (clean.components[0].chains != solution.components[0].chains) continue;
    ++compared;
    worst = std::max(worst, team.ate_m(solution) / team.ate_m(clean));
  }
  std::sort(cold.begin(), cold.end());
  std::sort(warm.begin(), warm.end());
  fmt::print(
      "{:32} cold {:6.1f} ms (most {:6.1f})  warm {:6.1f} ms  right kept {:4.1f}  wrong kept {:5.2f}  chains in the "
      "map "
      "{:.2f}  misplaced {}  worst error against no wrong links {:.2f} x ({} teams)\n",
      wrong.name, cold[cold.size() / 2], cold.back(), warm[warm.size() / 2], static_cast<double>(right) / seeds,
      static_cast<double>(kept_wrong) / seeds, static_cast<double>(in_map) / seeds, misplaced, worst, compared);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Size {
  int chains, anchors, links;  // of all chains; a sixth of the links are own loops
};

// A whole team from nothing; then again with one link more, from the poses in use, which are all that a Solution says.
void run_size(const Size& size) {
  PoseGraphTeam team(77, {.chains = size.chains, .anchors = size.anchors});
  team.add_right_links(size.links * 5 / 6);
  team.add_right_loops(size.links / 6);
  const PoseGraph graph = team.graph();
  team.add_right_links(1);
  const PoseGraph more = team.graph();
  std::vector<double> cold, warm;
  GraphSolution solution, next;
  for (int i = 0; i < 5; ++i) {
    const double start = cpu_ms();
    solution = graph.solve();
    cold.push_back(cpu_ms() - start);
    GraphSolution in_use = solution;
    in_use.links.clear();
    const double again = cpu_ms();
    next = more.solve(&in_use);
    warm.push_back(cpu_ms() - again);
  }
  fmt::print(
      "{:2} robots x {:3} anchors, {:5} links: cold {:6.1f} ms, {:2} steps; one link more {:6.1f} ms, {:2} steps; {} "
      "in the map{}\n",
      size.chains, size.anchors, size.links, median(cold), solution.effort.factorisations, median(warm),
      next.effort.factorisations, next.components[0].chains.size(), next.effort.converged ? "" : ", NOT CONVERGED");
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 20;
  for (const Case& wrong :
       {Case{"no wrong links", 0, 0, false}, Case{"70 % random", 93, 0, false}, Case{"95 % random", 760, 0, false},
        Case{"70 % look-alike, one place each", 0, 15, true}, Case{"70 % look-alike, all along", 0, 15, false},
        Case{"95 % look-alike, one place each", 0, 126, true}, Case{"95 % look-alike, all along", 0, 126, false}})
    run(wrong, seeds);
  for (const Size& size : {Size{2, 60, 48},
                           {5, 60, 120},
                           {10, 60, 240},
                           {20, 60, 480},
                           {5, 60, 600},
                           {10, 60, 1200},
                           {20, 60, 2400},
                           {20, 300, 2400},
                           {20, 300, 12000}})
    run_size(size);
}
