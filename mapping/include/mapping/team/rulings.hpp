#pragma once
#include <map>
#include <utility>
#include <vector>

#include "mapping/records/ruling.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// What counts of what people said of pairs of chains: a function of the records, in whatever order they came.
class Rulings {
 public:
  struct Ruling {
    bool apart = false;
    std::uint32_t turn = 0;
    ChainId by;  // whose log it is in
  };
  Rulings() = default;
  explicit Rulings(const std::map<ChainId, TeamMember>& members);

  bool apart(const ChainId& a, const ChainId& b) const;
  const Ruling* find(const ChainId& a, const ChainId& b) const;  // nullptr: nobody said anything

 private:
  std::map<std::pair<ChainId, ChainId>, Ruling> by_pair_;  // lower chain first
};

}  // namespace onemap::mapping
