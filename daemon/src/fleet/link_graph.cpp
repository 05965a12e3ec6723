#include "daemon/fleet/link_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>

namespace onemap::daemon {

namespace {

Result<FleetLink> parse_link(const std::string& graph, const std::string& text, std::size_t robots) {
  const auto refused = [&](const std::string& why) { return Error{"graph '" + graph + "'", "'" + text + "' " + why}; };
  std::size_t a = 0, b = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, a);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '-') return refused("is not a link such as 1-2");
  const auto second = std::from_chars(first.ptr + 1, end, b);
  if (second.ec != std::errc() || second.ptr != end) return refused("is not a link such as 1-2");
  if (a < 1 || b < 1 || a > robots || b > robots) return refused(fmt::format("names a robot outside 1..{}", robots));
  if (a == b) return refused("links a robot to itself");
  return FleetLink{std::min(a, b) - 1, std::max(a, b) - 1};
}

}  // namespace

Result<std::vector<FleetLink>> parse_graph(const std::string& text, std::size_t robots) {
  std::set<FleetLink> links;
  if (text == "complete") {
    for (std::size_t i = 0; i < robots; ++i)
      for (std::size_t j = i + 1; j < robots; ++j) links.insert({i, j});
  } else if (text == "line" || text == "ring") {
    for (std::size_t i = 0; i + 1 < robots; ++i) links.insert({i, i + 1});
    if (text == "ring" && robots > 2) links.insert({0, robots - 1});
  } else if (text == "star") {
    for (std::size_t i = 1; i < robots; ++i) links.insert({0, i});
  } else {
    if (text.empty() || text.back() == ',')
      return Error{"graph '" + text + "'", "ends where a link such as 1-2 is expected"};
    std::istringstream list(text);
    for (std::string item; std::getline(list, item, ',');) {
      auto link = parse_link(text, item, robots);
      if (!link) return Error{link.error().place, link.error().reason + "; known: complete, line, ring, star"};
      links.insert(*link);
    }
  }
  return std::vector<FleetLink>(links.begin(), links.end());
}

}  // namespace onemap::daemon
