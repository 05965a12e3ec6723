#include "in_use.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

InUse::Link state_of(LinkUse use) {
  if (use == LinkUse::used) return InUse::Link::used;
  return use == LinkUse::outlier || use == LinkUse::contradicts_chain ? InUse::Link::dropped : InUse::Link::unknown;
}

}  // namespace

InUse in_use_of(const GraphIndex& index, const GraphSolution* solution) {
  InUse out;
  out.anchors.resize(index.ids.size());
  out.links.resize(index.links.size());
  if (solution == nullptr) return out;
  for (std::size_t i = 0; i < index.ids.size(); ++i)
    if (const SolvedAnchor* anchor = solution->find(index.ids[i]))
      out.anchors[i] = InUse::Placed{anchor->component, anchor->T_map_anchor};
  for (std::size_t i = 0; i < index.links.size(); ++i)
    if (const LinkVerdict* link = solution->find(index.links[i].id)) out.links[i] = state_of(link->use);
  for (const GraphComponent& component : solution->components) {
    const auto at = std::lower_bound(index.ids.begin(), index.ids.end(), component.reference);
    if (at != index.ids.end() && *at == component.reference)
      out.references.push_back(static_cast<std::size_t>(at - index.ids.begin()));
  }
  return out;
}

}  // namespace onemap::mapping
