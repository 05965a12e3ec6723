#include "pair_links.hpp"

#include <cmath>

#include "link_motion.hpp"
#include "se3.hpp"

namespace onemap::mapping {

namespace {

// Of the chains' own ways along the ring: from a to a on one chain and from b to b on the other.
Matrix6d of_ways(const ChainFrames& frames, const LinkMotion& p, const LinkMotion& q) {
  if (p.own) return frames.of_ring(p.link->a, p.link->b, q.link->a, q.link->b);
  return frames.between(p.link->a, q.link->a) + p.y_to_x * frames.between(p.link->b, q.link->b) * p.y_to_x.transpose();
}

bool agree(const ChainFrames& frames, const LinkMotion& p, const LinkMotion& q, double chi2) {
  const Vector6d error = motion_error(p.T_a_x * (p.T_x_y * q.T_x_y.inverse()) * p.T_a_x.inverse());
  const auto turn = [&](std::size_t a, std::size_t b) { return std::abs(frames.turn[b] - frames.turn[a]); };
  // Chi square is at least the squared error over the trace: most pairs with a wrong link need no more than this.
  const double ways = turn(p.link->a, q.link->a) + turn(p.link->b, q.link->b);
  const double most = p.turn + q.turn + (p.own ? 2 * ways : ways);
  if (error.head<3>().squaredNorm() > chi2 * most) return false;
  const Matrix6d in_x = p.covariance + q.covariance + of_ways(frames, p, q);
  return chi_square(error, p.to_a * in_x * p.to_a.transpose()) <= chi2;
}

}  // namespace

double against_odometry(const ChainFrames& frames, const GraphEdge& loop) {
  const LinkMotion p = motion_of(frames, loop, true);
  const Vector6d error = motion_error(p.T_a_x * p.T_x_y * p.T_a_x.inverse());
  return chi_square(error, p.to_a * (p.covariance + frames.between(loop.a, loop.b)) * p.to_a.transpose());
}

AgreementGraph agreement_of(const ChainFrames& frames, std::span<const GraphEdge* const> links, bool own, double chi2) {
  std::vector<LinkMotion> motions;
  for (const GraphEdge* link : links) motions.push_back(motion_of(frames, *link, own));
  AgreementGraph out(links.size());
  for (std::size_t i = 0; i < motions.size(); ++i)
    for (std::size_t j = i + 1; j < motions.size(); ++j)
      if (agree(frames, motions[i], motions[j], chi2)) out.set(i, j);
  return out;
}

}  // namespace onemap::mapping
