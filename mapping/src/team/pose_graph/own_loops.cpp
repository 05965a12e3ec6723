#include "own_loops.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <tuple>

#include "link_motion.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "se3.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kWitnesses = 5;  // of the loops that were taken, the last ones

struct Loop {
  std::size_t link = 0, early = 0, late = 0;  // of the index
  Pose T_early_late{};
  Matrix6d covariance{};  // of small motions at the right of T_early_late
};

Loop loop_of(const GraphIndex& index, std::size_t link) {
  const GraphEdge& edge = index.links[link].edge;
  const Matrix6d at_b = edge.information.llt().solve(Matrix6d::Identity());
  if (edge.a <= edge.b) return {link, edge.a, edge.b, edge.T_a_b, at_b};
  const Matrix6d to_a = adjoint(edge.T_a_b);
  return {link, edge.b, edge.a, edge.T_a_b.inverse(), to_a * at_b * to_a.transpose()};
}

class Walk {
 public:
  Walk(const GraphIndex& index, const IndexedChain& chain, double chi2, ChainFrames& frames)
      : index_(index), chi2_(chi2), frames_(frames), here_(chain.first), bent_(chain.first) {}

  void go_to(std::size_t anchor) {
    for (; here_ < anchor; ++here_) place(here_ + 1, pose(here_) * index_.anchors[here_ + 1]->T_previous_anchor);
  }
  // Nothing: it fits. Else chi square of what it fits least.
  double misfit(const Loop& loop) const {
    const double alone = surprise(loop, pose(loop.late), Matrix6d::Zero(), frames_.between(loop.early, loop.late));
    if (alone > chi2_) return alone;
    const auto [against, most] = votes(loop);
    return 2 * against > taken_.size() + 1 ? most : 0;
  }
  // The way since the last one bends to it, evenly.
  void take(const Loop& loop) {
    const std::size_t from = std::max(bent_, loop.early);
    if (loop.late > from) bend(from, loop.late, pose(loop.early) * loop.T_early_late);
    bent_ = std::max(bent_, loop.late);
    if (taken_.size() == kWitnesses) taken_.erase(taken_.begin());
    taken_.push_back(loop);
  }

 private:
  // How many of the last ones are against it, and the most that it misses one of them by.
  std::pair<std::size_t, double> votes(const Loop& loop) const {
    std::pair<std::size_t, double> out{0, 0};
    for (const Loop& witness : taken_) {
      const double misses = against_witness(loop, witness);
      out.first += misses > chi2_ ? 1 : 0;
      out.second = std::max(out.second, misses);
    }
    return out;
  }
  const Pose& pose(std::size_t anchor) const { return frames_.T_chain_anchor[anchor]; }
  void place(std::size_t anchor, Pose at) {
    at.R = orthonormal(at.R);
    frames_.place(index_, anchor, at);
  }
  void bend(std::size_t from, std::size_t to, const Pose& end) {
    const Pose before = pose(to);
    const Matrix3d turn = end.R * before.R.transpose();
    const Vector3d way = end.t - before.t;
    for (std::size_t i = from + 1; i <= to; ++i) {
      const double share = static_cast<double>(i - from) / static_cast<double>(to - from);
      place(i, between(pose(i), {turn * pose(i).R, pose(i).t + way}, share));
    }
  }
  // Of the later end, which the loop has elsewhere than it is expected; unsure: at the right of that pose, and in the
  // chain's frame.
  double surprise(const Loop& loop, const Pose& expected, const Matrix6d& unsure, const Matrix6d& of_ways) const {
    const Vector6d error = motion_error((pose(loop.early) * loop.T_early_late).inverse() * expected);
    const Matrix6d to_late = adjoint(expected.inverse());
    return chi_square(error, loop.covariance + unsure + to_late * of_ways * to_late.transpose());
  }
  double against_witness(const Loop& loop, const Loop& witness) const {
    const Pose T_witness_late = pose(witness.late).inverse() * pose(loop.late);
    const Matrix6d to_late = adjoint(T_witness_late.inverse());
    return surprise(loop, pose(witness.early) * witness.T_early_late * T_witness_late,
                    to_late * witness.covariance * to_late.transpose(),
                    frames_.of_ring(loop.early, loop.late, witness.early, witness.late));
  }

  const GraphIndex& index_;
  double chi2_;
  ChainFrames& frames_;
  std::size_t here_;         // so far the way goes
  std::size_t bent_;         // and so far it was bent
  std::vector<Loop> taken_;  // the last ones
};

}  // namespace

FollowedLoops follow_loops(const GraphIndex& index, const IndexedChain& chain, const std::vector<std::size_t>& links,
                           double chi2, ChainFrames& frames) {
  std::vector<Loop> loops;
  loops.reserve(links.size());
  for (std::size_t link : links) loops.push_back(loop_of(index, link));
  std::stable_sort(loops.begin(), loops.end(),
                   [](const Loop& x, const Loop& y) { return std::tie(x.late, x.early) < std::tie(y.late, y.early); });
  FollowedLoops out;
  Walk walk(index, chain, chi2, frames);
  for (const Loop& loop : loops) {
    walk.go_to(loop.late);
    if (const double misfit = walk.misfit(loop); misfit > 0) {
      out.refused.emplace_back(loop.link, misfit);
      continue;
    }
    walk.take(loop);
    out.agreeing.push_back(loop.link);
  }
  walk.go_to(chain.first + chain.count - 1);
  std::sort(out.agreeing.begin(), out.agreeing.end());
  return out;
}

}  // namespace onemap::mapping
