#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/scenario.hpp"

namespace onemap::comms::sim {

namespace {
double ms(Duration time) { return to_seconds(time) * 1e3; }

std::string name(Fault::Kind kind) {
  switch (kind) {
    case Fault::Kind::partition:
      return "partition";
    case Fault::Kind::clog:
      return "clog";
    case Fault::Kind::crash:
      return "crash";
    case Fault::Kind::wipe:
      return "wipe";
    case Fault::Kind::forget_life:
      return "forget_life";
    case Fault::Kind::stop:
      return "stop";
    case Fault::Kind::clock_jump:
      return "clock_jump";
    case Fault::Kind::storm:
      return "storm";
    case Fault::Kind::full_disk:
      return "full_disk";
  }
  return "?";
}
}  // namespace

std::string text_of(const Fault& fault) {
  std::string text =
      fmt::format("{:9.3f} s  {} for {:.3f} s", to_seconds(fault.at), name(fault.kind), to_seconds(fault.lasts));
  if (fault.kind == Fault::Kind::partition) {
    text += fault.one_way ? ", one way, from " : ", ";
    for (const bool in : fault.side) text += in ? '1' : '0';
  } else if (fault.kind == Fault::Kind::storm) {
    text += fmt::format(", loss {:.0f} %", 100 * fault.loss);
  } else {
    text += fmt::format(", robot{}", fault.robot);
    if (fault.kind == Fault::Kind::clog) text += fmt::format(" to robot{}", fault.other);
  }
  return text;
}

std::string text_of(const Scenario& scenario) {
  const LinkModel& links = scenario.links;
  std::string text =
      fmt::format("seed {}: {} robots, {}{}{}{} of faults, then peace\n", scenario.seed, scenario.robots,
                  scenario.sealed ? "with a key, " : "",
                  scenario.disks ? fmt::format("with disks ({} polls a sync), ", scenario.sync_polls) : "",
                  scenario.hostile ? scenario.hostile_stays ? "a hostile one that stays, " : "a hostile one, " : "",
                  fmt::format("{:.3f} s", to_seconds(scenario.chaos)));
  if (scenario.field.reach > 0)
    text += fmt::format("  field: reach {:.2f}, speed {:.2f}\n", scenario.field.reach, scenario.field.speed);
  else
    text += fmt::format("  edges: {}\n", fmt::join(scenario.edges, " "));
  text += fmt::format(
      "  links: loss {:.1f} %, copies {:.1f} %, delay {:.1f} ms + {:.1f} ms jitter + {:.1f} ms tail, held back {:.1f} "
      "%, "
      "flipped {:.2f} %, bursts of {:.0f} ms every {:.0f} ms, {} bytes/s\n",
      100 * links.loss, 100 * links.duplication, ms(links.delay), ms(links.jitter), ms(links.delay_tail),
      100 * links.held_back, 100 * links.flipped, ms(links.burst_lasts), ms(links.burst_every), links.bytes_per_second);
  text += fmt::format(
      "  node: credit {}, reassembly {}, {} bytes/s, silent after {:.1f} s; air {} bytes/s; {} writes, {} of "
      "kinds that are replaced\n",
      scenario.node.credit_bytes, scenario.node.reassembly_bytes, scenario.node.bytes_per_second,
      to_seconds(scenario.node.neighbour_timeout), scenario.air.bytes_per_second, scenario.writes.size(),
      std::count_if(scenario.writes.begin(), scenario.writes.end(),
                    [](const Write& write) { return write.kind != kAlways; }));
  for (const Fault& fault : scenario.faults) text += "  " + text_of(fault) + "\n";
  return text;
}

}  // namespace onemap::comms::sim
