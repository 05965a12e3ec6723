#pragma once
#include <optional>
#include <vector>

#include "graph_index.hpp"

namespace onemap::mapping {

// The solution in use, by the places of the index.
struct InUse {
  struct Placed {
    std::uint32_t component = 0;
    QuantizedPose pose;
  };
  enum class Link : std::uint8_t { unknown, used, dropped };

  std::vector<std::optional<Placed>> anchors;
  std::vector<Link> links;
  std::vector<std::size_t> references;  // anchors, of the components in their order; those that are still in the graph
};
InUse in_use_of(const GraphIndex& index, const GraphSolution* solution);

}  // namespace onemap::mapping
