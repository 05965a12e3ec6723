#include "chain_frame.hpp"

#include <Eigen/Cholesky>

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
      const Matrix6d to_chain = adjoint(pose);
      const Matrix6d step = anchor.information.llt().solve(Matrix6d::Identity());
      out.covariance.push_back(out.covariance.back() + to_chain * step * to_chain.transpose());
      out.T_chain_anchor.push_back(pose);
    }
  for (const Matrix6d& covariance : out.covariance) out.turn.push_back(covariance.topLeftCorner<3, 3>().trace());
  return out;
}

}  // namespace onemap::mapping
