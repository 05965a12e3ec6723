#pragma once
#include <Eigen/Geometry>
#include <set>
#include <string>
#include <vector>

#include "mapping/team/pose_graph.hpp"
#include "poses.hpp"

// Simulated chains with drift, right and wrong links between them, and how far a solution is from truth.
namespace onemap::test {

struct TeamSpec {
  int chains = 3, anchors = 60;
  double drift_m = 0.004, drift_rad = 0.003;  // a step, on each axis
  double step_m = 0.25;
};

class PoseGraphTeam {
 public:
  PoseGraphTeam(std::uint64_t seed, const TeamSpec& spec = {}) : random_(seed), spec_(spec) {
    for (int c = 0; c < spec.chains; ++c) chains_.push_back(walk(c));
  }

  static mapping::ChainId chain_id(int chain) {
    return {RobotId::from_name(std::string(1, static_cast<char>('a' + chain))), 1};
  }
  const std::vector<mapping::GraphLink>& links() const { return links_; }
  const std::set<mapping::LinkId>& right() const { return right_; }
  const mapping::Pose& truth(int chain, int anchor) const { return truth_[at(chain)][at(anchor)]; }

  // Between anchors of two chains that are less than 3 m apart.
  void add_right_links(int count) {
    while (count > 0) {
      const auto [a, b] = two_chains();
      const int i = anchor(), j = anchor();
      if ((truth(a, i).t - truth(b, j).t).norm() > 3) continue;
      if (!add(a, i, b, j, noisy(truth(a, i).inverse() * truth(b, j)))) continue;
      right_.insert(links_.back().id());
      --count;
    }
  }
  void add_right_link(int a, int i, int b, int j) {
    if (add(a, i, b, j, noisy(truth(a, i).inverse() * truth(b, j)))) right_.insert(links_.back().id());
  }
  // Own loops: places that a chain comes back to, at least 15 anchors later.
  void add_right_loops(int count) {
    while (count > 0) {
      const int c = a_chain(), i = anchor(), j = anchor();
      if (j < i + 15 || (truth(c, i).t - truth(c, j).t).norm() > 3) continue;
      if (!add(c, i, c, j, noisy(truth(c, i).inverse() * truth(c, j)))) continue;
      right_.insert(links_.back().id());
      --count;
    }
  }
  void add_random_wrong_loops(int count) {
    while (count > 0) {
      const int c = a_chain(), i = anchor(), j = anchor();
      if (i < j && add(c, i, c, j, random_pose(random_, 3.1, 3))) --count;
    }
  }
  void add_random_wrong_links(int count) {
    while (count > 0) {
      const auto [a, b] = two_chains();
      if (add(a, anchor(), b, anchor(), random_pose(random_, 3.1, 3))) --count;
    }
  }
  // Links that agree with each other on one wrong place of chain b in chain a; from one place, or all along.
  void add_look_alikes(int count, bool one_place) {
    const auto [a, b] = two_chains();
    add_look_alikes(count, one_place, a, b);
  }
  void add_look_alikes(int count, bool one_place, int a, int b) {
    mapping::Pose wrong = random_pose(random_, 0, 8);
    wrong.R = rotation({0, 0, 1}, random_.uniform(-3.1, 3.1));
    const int i0 = std::min(anchor(), spec_.anchors - 4), j0 = std::min(anchor(), spec_.anchors - 4);
    for (int tries = 0; count > 0; ++tries) {  // wider where others have taken the anchors
      const int reach = 4 + tries / 16;
      const int i = one_place ? near(i0, reach) : anchor(), j = one_place ? near(j0, reach) : anchor();
      if (add(a, i, b, j, noisy(truth(a, i).inverse() * wrong * truth(b, j)))) --count;
    }
  }
  // A place of chain b that looks like one of chain a: links between all that is near it, at most so many anchors from
  // it, and that would be near each other if it were the same place. Fewer where there are no more.
  void add_doubles(int count, int reach, int a, int b) {
    const int i0 = anchor(), j0 = anchor();
    const mapping::Pose T_i0_j0{rotation({0, 0, 1}, random_.uniform(-0.3, 0.3)),
                                {random_.uniform(-0.5, 0.5), random_.uniform(-0.5, 0.5), 0}};
    const mapping::Pose wrong = truth(a, i0) * T_i0_j0 * truth(b, j0).inverse();
    for (int tries = 0; count > 0 && tries < 20'000; ++tries) {
      const int i = anchor(), j = anchor();
      const mapping::Pose T_i_j = truth(a, i).inverse() * wrong * truth(b, j);
      if (std::abs(i - i0) > reach || std::abs(j - j0) > reach || T_i_j.t.norm() > 3) continue;
      if (add(a, i, b, j, noisy(T_i_j))) --count;
    }
  }

  mapping::PoseGraph graph(bool right_only = false, const mapping::PoseGraphConfig& config = {}) const {
    mapping::PoseGraph out(config);
    for (int c = 0; c < spec_.chains; ++c) (void)out.set_chain(chain_id(c), chains_[at(c)]);
    for (const auto& link : links_)
      if (!right_only || right_.contains(link.id())) (void)out.set_link(link);
    return out;
  }
  const std::vector<mapping::ChainAnchor>& chain(int c) const { return chains_[at(c)]; }

  // Root mean square distance of a component's anchors to truth after the best rigid motion.
  double ate_m(const mapping::GraphSolution& solution, std::uint32_t component = 0) const {
    std::vector<mapping::Vector3d> is, should;
    for (const auto& anchor : solution.anchors) {
      if (anchor.component != component) continue;
      is.push_back(mapping::from_quantized(anchor.T_map_anchor).t);
      should.push_back(truth(anchor.id.chain.robot.bytes[0] - 'a', static_cast<int>(anchor.id.keyframe)).t);
    }
    Eigen::Matrix3Xd from(3, is.size()), to(3, is.size());
    for (std::size_t i = 0; i < is.size(); ++i) {
      from.col(static_cast<Eigen::Index>(i)) = is[i];
      to.col(static_cast<Eigen::Index>(i)) = should[i];
    }
    const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
    const Eigen::Matrix3Xd error = ((T.topLeftCorner<3, 3>() * from).colwise() + T.topRightCorner<3, 1>()) - to;
    return std::sqrt(error.colwise().squaredNorm().mean());
  }
  int used(const mapping::GraphSolution& solution, bool right) const {
    int n = 0;
    for (const auto& link : solution.links)
      n += link.use == mapping::LinkUse::used && right_.contains(link.id) == right;
    return n;
  }
  // Chains joined in twos by wrong links alone: how often a component's placement of a chain is far from truth.
  int misplaced_chains(const mapping::GraphSolution& solution, double bound_m = 1) const {
    int n = 0;
    for (const auto& component : solution.components)
      for (std::size_t k = 1; k < component.chains.size(); ++k)
        n += chain_error_m(solution, component.chains[0], component.chains[k]) > bound_m;
    return n;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int anchor() { return static_cast<int>(random_.integer(0, spec_.anchors - 1)); }
  int near(int i, int reach) {
    return std::min(spec_.anchors - 1, i + static_cast<int>(random_.integer(0, reach - 1)));
  }
  int a_chain() { return static_cast<int>(random_.integer(0, spec_.chains - 1)); }
  std::pair<int, int> two_chains() {
    const int a = a_chain(), b = a_chain();
    return a == b ? two_chains() : std::pair{std::min(a, b), std::max(a, b)};
  }
  mapping::Pose noise(double rotation_rad, double translation_m) {
    mapping::Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = random_.normal(i < 3 ? rotation_rad : translation_m);
    return mapping::small_motion(d);
  }
  mapping::Pose noisy(const mapping::Pose& pose) { return pose * noise(0.0122, 0.02); }

  // A way through a hall of some ten metres: a large bend with a smaller one on it, other ones for each chain.
  std::vector<mapping::ChainAnchor> walk(int c) {
    truth_.emplace_back();
    std::vector<mapping::ChainAnchor> out;
    mapping::Pose pose{rotation({0, 0, 1}, random_.uniform(-3.1, 3.1)),
                       {random_.uniform(-1, 1), random_.uniform(-1, 1), 0.1 * c}};
    const double bend = random_.uniform(0.08, 0.16);
    for (int i = 0; i < spec_.anchors; ++i) {
      mapping::ChainAnchor anchor;
      anchor.keyframe = static_cast<std::uint32_t>(i);
      anchor.box_half_m = {1, 1, 1};
      if (i > 0) {
        const mapping::Pose step{rotation({0, 0, 1}, bend + 0.15 * std::sin(0.4 * i + c)), {spec_.step_m, 0, 0}};
        pose = pose * step;
        anchor.T_previous_anchor = step * noise(spec_.drift_rad, spec_.drift_m);
        anchor.information = mapping::information_of(spec_.drift_rad, spec_.drift_m);
      }
      truth_.back().push_back(pose);
      out.push_back(anchor);
    }
    return out;
  }
  bool add(int a, int i, int b, int j, const mapping::Pose& T_a_b) {
    mapping::GraphLink link;
    link.a = {.chain = chain_id(a),
              .keyframe = static_cast<std::uint32_t>(i),
              .anchor = static_cast<std::uint32_t>(i),
              .T_anchor_keyframe = {}};
    link.b = {.chain = chain_id(b),
              .keyframe = static_cast<std::uint32_t>(j),
              .anchor = static_cast<std::uint32_t>(j),
              .T_anchor_keyframe = {}};
    link.T_a_b = T_a_b;
    if (!taken_.insert(link.id()).second) return false;
    links_.push_back(link);
    return true;
  }
  double chain_error_m(const mapping::GraphSolution& solution, const mapping::ChainId& x,
                       const mapping::ChainId& y) const {
    const auto solved = [&](const mapping::ChainId& chain) {
      return mapping::from_quantized(solution.find(mapping::AnchorId{chain, 0})->T_map_anchor);
    };
    const auto true_pose = [&](const mapping::ChainId& chain) { return truth(chain.robot.bytes[0] - 'a', 0); };
    return ((solved(x).inverse() * solved(y)).t - (true_pose(x).inverse() * true_pose(y)).t).norm();
  }

  Random random_;
  TeamSpec spec_;
  std::vector<std::vector<mapping::Pose>> truth_;
  std::vector<std::vector<mapping::ChainAnchor>> chains_;
  std::vector<mapping::GraphLink> links_;
  std::set<mapping::LinkId> right_, taken_;
};

}  // namespace onemap::test
