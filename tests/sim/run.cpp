#include "sim/run.hpp"

#include <utility>

#include "sim/play.hpp"

namespace onemap::comms::sim {

Outcome run(const Scenario& scenario, const Trace& trace) {
  Play play(scenario);
  if (trace) play.tell(trace);
  play.faults();
  play.peace();
  return play.outcome();
}

namespace {
bool fails(const Scenario& scenario) { return !run(scenario).failure.empty(); }

// Leaves out one after another, larger parts first.
template <class T>
bool shorten(Scenario& scenario, std::vector<T> Scenario::*list) {
  bool shorter = false;
  for (std::size_t part = (scenario.*list).size(); part > 0; part /= 2)
    for (std::size_t at = 0; at + part <= (scenario.*list).size();) {
      Scenario less = scenario;
      const auto begin = (less.*list).begin() + static_cast<std::ptrdiff_t>(at);
      (less.*list).erase(begin, begin + static_cast<std::ptrdiff_t>(part));
      if (fails(less))
        scenario = std::move(less), shorter = true;
      else
        at += part;
    }
  return shorter;
}

template <class Change>
bool simplify(Scenario& scenario, Change change) {
  Scenario simpler = scenario;
  if (!change(simpler) || !fails(simpler)) return false;
  scenario = std::move(simpler);
  return true;
}

template <class T>
bool reset(T& value, const T& plain) {
  if (value == plain) return false;
  value = plain;
  return true;
}
}  // namespace

Scenario shrink(Scenario scenario) {
  for (bool smaller = true; smaller;) {
    smaller = shorten(scenario, &Scenario::faults);
    smaller |= shorten(scenario, &Scenario::writes);
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.hostile, false); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.air.bytes_per_second, std::uint64_t{0}); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.flipped, 0.0); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.duplication, 0.0); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.held_back, 0.0); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.burst_every, Duration{}); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.delay_tail, Duration{}); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.jitter, Duration{}); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.loss, 0.0); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.links.bytes_per_second, std::uint64_t{0}); });
    smaller |= simplify(scenario, [](Scenario& s) { return reset(s.field.speed, 0.0); });
  }
  return scenario;
}

}  // namespace onemap::comms::sim
