#include "pair_links.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "se3.hpp"

namespace onemap::mapping {

namespace {

double chi_square(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.llt().solve(error));
}

// What a link says of its two chains, prepared for comparing it with many.
struct Prepared {
  const GraphEdge* link = nullptr;
  bool own = false;       // both ends on one chain
  Pose T_x_y{};           // chain y's frame in chain x's
  Pose T_a_x{};           // chain x in anchor a: errors are looked at there, without the lever arm of the chain's frame
  Matrix6d covariance{};  // of T_x_y by the link alone, in chain x's frame
  Matrix6d to_a{}, y_to_x{};  // adjoints of T_a_x and T_x_y
  double turn = 0;            // trace of the covariance's rotation part: is the same in every frame
};

Prepared prepare(const ChainFrames& frames, const GraphEdge& link, bool own) {
  Prepared out{.link = &link, .own = own};
  const Pose T_x_b = frames.T_chain_anchor[link.a] * link.T_a_b;
  out.T_a_x = frames.T_chain_anchor[link.a].inverse();
  out.T_x_y = T_x_b * frames.T_chain_anchor[link.b].inverse();
  const Matrix6d b_to_x = adjoint(T_x_b);
  out.covariance = b_to_x * link.information.llt().solve(Matrix6d::Identity()) * b_to_x.transpose();
  out.to_a = adjoint(out.T_a_x);
  out.y_to_x = adjoint(out.T_x_y);
  out.turn = out.covariance.topLeftCorner<3, 3>().trace();
  return out;
}

// Of odometry along the ring: from a to a on one chain and from b to b on the other. On one chain the two may share
// steps, whose errors then cancel or count twice: what each step between the four anchors counts is a sum of signs.
Matrix6d of_ways(const ChainFrames& frames, const Prepared& p, const Prepared& q) {
  if (!p.own)
    return frames.between(p.link->a, q.link->a) +
           p.y_to_x * frames.between(p.link->b, q.link->b) * p.y_to_x.transpose();
  std::array<std::pair<std::size_t, int>, 4> ends{{{p.link->a, 1}, {p.link->b, -1}, {q.link->a, -1}, {q.link->b, 1}}};
  std::sort(ends.begin(), ends.end());
  Matrix6d out = Matrix6d::Zero();
  int sign = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    sign += ends[i].second;
    out += sign * sign * frames.between(ends[i].first, ends[i + 1].first);
  }
  return out;
}

bool agree(const ChainFrames& frames, const Prepared& p, const Prepared& q, double chi2) {
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
  const Prepared p = prepare(frames, loop, true);
  const Vector6d error = motion_error(p.T_a_x * p.T_x_y * p.T_a_x.inverse());
  return chi_square(error, p.to_a * (p.covariance + frames.between(loop.a, loop.b)) * p.to_a.transpose());
}

AgreementGraph agreement_of(const ChainFrames& frames, std::span<const GraphEdge* const> links, bool own, double chi2) {
  std::vector<Prepared> prepared;
  for (const GraphEdge* link : links) prepared.push_back(prepare(frames, *link, own));
  AgreementGraph out(links.size());
  for (std::size_t i = 0; i < prepared.size(); ++i)
    for (std::size_t j = i + 1; j < prepared.size(); ++j)
      if (agree(frames, prepared[i], prepared[j], chi2)) out.set(i, j);
  return out;
}

}  // namespace onemap::mapping
