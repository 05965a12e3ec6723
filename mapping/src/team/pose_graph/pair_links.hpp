#pragma once
#include <span>
#include <vector>

#include "agreement_graph.hpp"
#include "chain_frame.hpp"

namespace onemap::mapping {

// Chi square of 6 degrees of freedom of what an own loop says against what odometry says.
double against_odometry(const ChainFrames& frames, const GraphEdge& loop);

// Which of the links between two chains (own: of one) agree pairwise: the way from a to b by one link, along odometry
// and back by the other must close within what links and odometry are unsure of (Mangelson and others 2018). The
// covariance grows with the way along both chains and holds the lever arms of the rotations' errors.
AgreementGraph agreement_of(const ChainFrames& frames, std::span<const GraphEdge* const> links, bool own, double chi2);

}  // namespace onemap::mapping
