#include "chain_frame.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <utility>

#include "se3.hpp"

namespace onemap::mapping {

ChainFrames chain_frames(const GraphIndex& index) {
  ChainFrames out;
  for (const IndexedChain& chain : index.chains)
    for (std::size_t i = chain.first; i < chain.first + chain.count; ++i) {
      const ChainAnchor& anchor = *index.anchors[i];
      if (i == chain.first) {
        out.T_chain_anchor.push_back(anchor.T_previous_anchor);
        out.covariance.push_back(Matrix6d::Zero());
        continue;
      }
      Pose pose = out.T_chain_anchor.back() * anchor.T_previous_anchor;
      pose.R = orthonormal(pose.R);
      out.T_chain_anchor.emplace_back();
      out.covariance.emplace_back();
      out.place(index, i, pose);
    }
  for (const Matrix6d& covariance : out.covariance) out.turn.push_back(covariance.topLeftCorner<3, 3>().trace());
  return out;
}

Matrix6d ChainFrames::of_ring(std::size_t a, std::size_t b, std::size_t c, std::size_t d) const {
  std::array<std::pair<std::size_t, int>, 4> ends{{{a, 1}, {b, -1}, {c, -1}, {d, 1}}};
  std::sort(ends.begin(), ends.end());
  Matrix6d out = Matrix6d::Zero();
  int sign = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    sign += ends[i].second;
    out += sign * sign * between(ends[i].first, ends[i + 1].first);
  }
  return out;
}

void ChainFrames::place(const GraphIndex& index, std::size_t anchor, const Pose& T) {
  const Matrix6d to_chain = adjoint(T);
  const Matrix6d step = index.anchors[anchor]->information.llt().solve(Matrix6d::Identity());
  T_chain_anchor[anchor] = T;
  covariance[anchor] = covariance[anchor - 1] + to_chain * step * to_chain.transpose();
}

}  // namespace onemap::mapping
