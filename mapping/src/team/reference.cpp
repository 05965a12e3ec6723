#include "mapping/team/reference.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include "mapping/team/election.hpp"

namespace onemap::mapping {

namespace {

// "The most and best matches": how many features agree, weighted by the quality ratio. Integers, so ties are exact.
std::uint64_t quality(const LinkRecord& link) {
  return static_cast<std::uint64_t>(link.inliers) * std::max<std::uint32_t>(1, link.ratio_e4);
}

// The links that count, the best first: accepted, between robots that are known.
std::vector<LinkRecord> best_first(std::span<const RobotId> robots, std::span<const LinkRecord> links) {
  const auto known = [&](const RobotId& id) { return std::find(robots.begin(), robots.end(), id) != robots.end(); };
  std::vector<LinkRecord> out;
  for (const LinkRecord& link : links)
    if (link.reason == LinkReason::accepted && known(link.a) && known(link.b) && link.a != link.b) out.push_back(link);
  std::sort(out.begin(), out.end(), [](const LinkRecord& x, const LinkRecord& y) {
    if (quality(x) != quality(y)) return quality(x) > quality(y);
    if (x.a != y.a) return x.a < y.a;
    if (x.b != y.b) return x.b < y.b;
    return x.T_a_b < y.T_a_b;
  });
  return out;
}

RobotId most_matched(std::span<const RobotId> robots, const std::vector<LinkRecord>& links) {
  std::map<RobotId, std::uint64_t> sum;
  for (const RobotId& id : robots) sum[id] = 0;
  for (const LinkRecord& link : links)
    for (const RobotId& end : {link.a, link.b})
      if (const auto at = sum.find(end); at != sum.end()) at->second += quality(link);
  return std::max_element(sum.begin(), sum.end(), [](const auto& x, const auto& y) { return x.second < y.second; })
      ->first;
}

}  // namespace

SolutionRecord solve(std::span<const RobotId> robots, std::span<const LinkRecord> links) {
  SolutionRecord solution;
  if (robots.empty()) return solution;
  const std::vector<LinkRecord> good = best_first(robots, links);
  solution.reference = most_matched(islands(robots, good).front(), good);
  std::map<RobotId, Pose> placed{{solution.reference, Pose{}}};
  // Eq. (12), best link first: a maximum spanning tree grown from the reference.
  for (bool grown = true; grown;) {
    grown = false;
    for (const LinkRecord& link : good) {
      const auto a = placed.find(link.a), b = placed.find(link.b);
      if ((a == placed.end()) == (b == placed.end())) continue;
      const Pose T_a_b = from_quantized(link.T_a_b);
      if (a != placed.end())
        placed[link.b] = a->second * T_a_b;
      else
        placed[link.a] = b->second * T_a_b.inverse();
      ++solution.links_used;
      grown = true;
      break;
    }
  }
  for (const auto& [id, T] : placed) solution.robots.push_back({id, quantize(T)});
  return solution;
}

}  // namespace onemap::mapping
