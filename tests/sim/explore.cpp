#include "sim/explore.hpp"

#include <chrono>

namespace onemap::comms::sim {

Explored explore(const Exploring& team, std::uint64_t seed) {
  constexpr std::size_t kPoseBytes = 120;
  constexpr auto kPatience = std::chrono::seconds(10);
  const auto start = std::chrono::steady_clock::now();
  Random random(seed);
  SimNet net(seed, {.loss = 0.01, .delay = std::chrono::milliseconds(5)});
  net.add_team(team.robots, connected(team.robots, team.robots * (team.degree - 2) / 2 + 1, random));
  Explored out;
  const Instant begin = net.now();
  // Not all at the same moment: a robot each `step`, in turn.
  const Duration step = team.every / static_cast<std::int64_t>(team.robots);
  for (std::size_t i = 0; net.now() - begin < team.lasts; i = (i + 1) % team.robots, ++out.records) {
    net.append(i, 1, kPoseBytes);
    net.run_for(step);
  }
  const Instant quiet = net.now();
  out.equal = net.run_until([&] { return net.equal() && net[0].applied.size() == out.records; }, kPatience);
  out.to_equal = net.now() - quiet;
  out.simulated = net.now() - begin;
  out.datagrams = net.datagrams_carried(), out.bytes = net.bytes_carried();
  out.real_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace onemap::comms::sim
