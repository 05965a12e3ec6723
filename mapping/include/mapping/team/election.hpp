#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mapping/team/link_table.hpp"

// Who decides for the team. Anyone can compute it, so anyone can take over.
namespace onemap::mapping {

// The chains in groups that accepted links join, directly or through others: the largest group first, of equal ones
// that with the lowest id; each group sorted.
std::vector<std::vector<ChainId>> islands(std::span<const ChainId> chains, std::span<const TeamLink> links);

// The lowest id that may decide, of the first island that has one: a robot that nothing joins to the map never decides
// over those that are in it. Nothing when nobody may.
std::optional<RobotId> elect(const std::vector<std::vector<ChainId>>& islands,
                             const std::function<bool(const ChainId&)>& may_decide);

}  // namespace onemap::mapping
