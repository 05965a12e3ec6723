// How fast what is missing could come at best.
#include <algorithm>
#include <cmath>

#include "comms/wire/payload.hpp"
#include "sim/play.hpp"

namespace onemap::comms::sim {

namespace {
struct OnWire {
  std::size_t bytes = 0;  // the payload, and what stands before each of its fragments
  std::uint32_t fragments = 0;
};
OnWire on_wire(const Record& record) {
  const std::uint32_t bytes = wire::payload_bytes(record), fragments = wire::fragments_of(bytes);
  return {bytes + fragments * (wire::kHeaderBytes + wire::kFrameHeadBytes + wire::kDataFixedBytes), fragments};
}

// In the mean so many times something is asked for until the last of so many fragments has come: whoever asks knows of
// a loss, on the way there or back, no sooner than after a round trip.
double rounds(std::uint32_t fragments, double loss) {
  const double fails = 1.0 - (1.0 - loss) * (1.0 - loss);
  double mean = 0.0, still_fails = 1.0;
  for (int round = 0; round < 100; ++round, still_fails *= fails)
    mean += 1.0 - std::pow(1.0 - still_fails, static_cast<double>(fragments));
  return mean;
}
}  // namespace

// Each robot receives what it lacks from its neighbours, each of whom sends at most at its own rate and the link's; and
// where the air is shared, all that is received around a robot takes its time.
Duration Play::bound() const {
  std::map<RecordId, OnWire> all;
  for (std::size_t i = 0; i < scenario_.robots; ++i)
    net_[i].store->scan([&](const auto& record) {  // where nobody dropped its body
      OnWire& most = all[record->id];
      if (const OnWire here = on_wire(*record); here.bytes > most.bytes) most = here;
    });
  std::uint32_t most_fragments = 1;  // of a record that somebody lacks
  std::vector<double> missing(scenario_.robots);
  for (std::size_t i = 0; i < scenario_.robots; ++i) {
    const VersionVector& here = net_.node(i).frontier();
    for (const auto& [id, size] : all) {
      const auto log = here.find(id.log);
      if (log != here.end() && log->second > id.seq) continue;
      missing[i] += static_cast<double>(size.bytes);
      most_fragments = std::max(most_fragments, size.fragments);
    }
  }
  double rate = static_cast<double>(scenario_.node.bytes_per_second);
  if (scenario_.links.bytes_per_second > 0)
    rate = std::min(rate, static_cast<double>(scenario_.links.bytes_per_second));
  // Jitter near the queue that the rate control aims at, 15 ms, looks like a queue to it, and it may go down to its
  // floor.
  constexpr Duration kLikeAQueue = std::chrono::milliseconds(12);
  if (scenario_.links.jitter + 2 * scenario_.links.delay_tail > kLikeAQueue)
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
  return Duration(static_cast<std::int64_t>(longest * 1e9)) + latency(most_fragments);
}

// Over each link of the longest way somebody is told, asks and is answered.
Duration Play::latency(std::uint32_t fragments) const {
  std::vector<Edge> edges;
  for (std::size_t a = 0; a < scenario_.robots; ++a)
    for (std::size_t b = a + 1; b < scenario_.robots; ++b)
      if (net_.reaches(a, b)) edges.emplace_back(a, b);
  int longest = 0;
  for (std::size_t from = 0; from < scenario_.robots; ++from)
    for (const int way : distances(scenario_.robots, edges, from)) longest = std::max(longest, way);
  const LinkModel& links = scenario_.links;
  const Duration one_way = links.delay + links.jitter / 2 + links.delay_tail;
  const double ways = 1.0 + 2.0 * rounds(fragments, links.loss);
  return Duration(static_cast<std::int64_t>(longest * ways * static_cast<double>(one_way.count())));
}

}  // namespace onemap::comms::sim
