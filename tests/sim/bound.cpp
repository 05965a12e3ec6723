// How fast what is missing could come at best.
#include <algorithm>

#include "sim/play.hpp"

namespace onemap::comms::sim {

namespace {
// On the wire: the body, and what stands before each of its fragments.
std::size_t wire_bytes(const Record& record) {
  const std::size_t fragments = wire::fragments_of(static_cast<std::uint32_t>(record.body.size()));
  return record.body.size() + fragments * (wire::kHeaderBytes + wire::kFrameHeadBytes + wire::kDataFixedBytes);
}
}  // namespace

// Each robot receives what it lacks from its neighbours, each of whom sends at most at its own rate and the link's; and
// where the air is shared, all that is received around a robot takes its time.
Duration Play::bound() const {
  std::map<RecordId, std::size_t> all;
  for (std::size_t i = 0; i < scenario_.robots; ++i)
    net_[i].store->scan([&](const auto& record) { all[record->id] = wire_bytes(*record); });
  std::vector<double> missing(scenario_.robots);
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    const VersionVector& here = net_.node(i).frontier();
    for (const auto& [id, bytes] : all) {
      const auto log = here.find(id.log);
      if (log == here.end() || log->second <= id.seq) missing[i] += static_cast<double>(bytes);
    }
  }
  double rate = static_cast<double>(scenario_.node.bytes_per_second);
  if (scenario_.links.bytes_per_second > 0)
    rate = std::min(rate, static_cast<double>(scenario_.links.bytes_per_second));
  // Jitter beyond the queue that the rate control aims at looks like a queue to it, and it may go down to its floor.
  constexpr Duration kQueueAimedAt = std::chrono::milliseconds(15);
  if (scenario_.links.jitter + 2 * scenario_.links.delay_tail > kQueueAimedAt)
    rate = std::min(rate, static_cast<double>(scenario_.node.link_least_bytes_per_second));
  const double arriving = 1.0 - scenario_.links.loss;
  double longest = 0.0;
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    double neighbours = 0, around = missing[i];
    for (std::size_t k = 0; k < scenario_.robots; ++k) {
      if (k == i || !net_.reaches(k, i)) continue;
      neighbours += 1;
      around += missing[k];
    }
    if (neighbours > 0) longest = std::max(longest, missing[i] / (neighbours * rate * arriving));
    if (scenario_.air.bytes_per_second > 0)
      longest = std::max(longest, around / (static_cast<double>(scenario_.air.bytes_per_second) * arriving));
  }
  return Duration(static_cast<std::int64_t>(longest * 1e9)) + latency();
}

// Over each link of the longest way somebody is told, asks and is answered.
Duration Play::latency() const {
  std::vector<Edge> edges;
  for (std::size_t a = 0; a < scenario_.robots; ++a)
    for (std::size_t b = a + 1; b < scenario_.robots; ++b)
      if (net_.reaches(a, b)) edges.emplace_back(a, b);
  int longest = 0;
  for (std::size_t from = 0; from < scenario_.robots; ++from)
    for (const int way : distances(scenario_.robots, edges, from)) longest = std::max(longest, way);
  const LinkModel& links = scenario_.links;
  return 3 * longest * (links.delay + links.jitter / 2 + links.delay_tail);
}

}  // namespace onemap::comms::sim
