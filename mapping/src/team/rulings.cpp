#include "mapping/team/rulings.hpp"

#include <algorithm>
#include <tuple>

namespace onemap::mapping {

Rulings::Rulings(const std::map<ChainId, TeamMember>& members) {
  // Ascending by author: of equal turns the last one stays.
  for (const auto& [author, member] : members)
    for (const auto& [pair, said] : member.rulings) {
      Ruling& counts = by_pair_[pair];
      if (said.turn >= counts.turn) counts = {said.apart, said.turn, author};
    }
}

const Rulings::Ruling* Rulings::find(const ChainId& a, const ChainId& b) const {
  const auto at = by_pair_.find(std::minmax(a, b));
  return at == by_pair_.end() ? nullptr : &at->second;
}

bool Rulings::apart(const ChainId& a, const ChainId& b) const {
  const Ruling* ruling = find(a, b);
  return ruling != nullptr && ruling->apart;
}

}  // namespace onemap::mapping
