#pragma once
#include <vector>

#include "in_use.hpp"
#include "least_squares.hpp"

namespace onemap::mapping {

// The weight of a squared error in the shape mu of truncated least squares: 1 below mu / (mu + 1) barc2, 0 above
// (mu + 1) / mu barc2, between as in Yang and others 2020. Shapes grow from nearly convex (0) to truncated (infinite).
double gnc_weight(double squared_error, double barc2, double mu);

// Graduated non-convexity over all links, starting from weights; leaves each at 0 or 1 and the poses solved with these.
// True: the last step was small.
bool solve_graduated(LeastSquares& squares, std::vector<double>& weights, const std::vector<InUse::Link>& in_use,
                     const GncConfig& config, bool warm, SolveEffort& effort);

}  // namespace onemap::mapping
