#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "graph_index.hpp"
#include "mapping/team/pose_graph_g2o.hpp"

namespace onemap::mapping {

namespace {

constexpr std::string_view kHead =
    "# onemap pose graph; X_map_anchor, metres; edges are X_a^-1 X_b\n"
    "# information for g2o's rotation error, the quaternion's vector part (half the angle): the rotation block is "
    "that\n"
    "# of radians times 4. Who takes radians divides it by 4 (and the cross blocks by 2).\n";

class Writer {
 public:
  Writer(const GraphIndex& index, const std::vector<ChainId>& chains) : index_(index), chains_(chains) {
    text_ = kHead;
    for (std::size_t i = 0; i < chains.size(); ++i)
      say("# chain {}: {} life {}, vertices from {}\n", i, chains[i].robot.name(), chains[i].incarnation, i << 20);
  }

  std::uint64_t vertex_id(const AnchorId& id) const {
    const auto at = std::lower_bound(chains_.begin(), chains_.end(), id.chain);
    return static_cast<std::uint64_t>(at - chains_.begin()) << 20 | id.keyframe;
  }
  void vertex(const SolvedAnchor& anchor) {
    say("VERTEX_SE3:QUAT {}", vertex_id(anchor.id));
    pose(from_quantized(anchor.T_map_anchor));
    text_ += '\n';
  }
  void fix(const AnchorId& id) { say("FIX {}\n", vertex_id(id)); }
  void edge(const GraphEdge& edge) {
    say("EDGE_SE3:QUAT {} {}", vertex_id(index_.ids[edge.a]), vertex_id(index_.ids[edge.b]));
    pose(edge.T_a_b);
    for (int row = 0; row < 6; ++row)
      for (int col = row; col < 6; ++col) say(" {}", for_g2o(edge.information, row, col));
    text_ += '\n';
  }
  std::string take() { return std::move(text_); }

 private:
  template <class... Args>
  void say(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void pose(const Pose& pose) {
    const auto q = to_quaternion_wxyz(pose.R);
    say(" {} {} {} {} {} {} {}", pose.t.x(), pose.t.y(), pose.t.z(), q[1], q[2], q[3], q[0]);
  }
  // Translation first, and an error of one unit of half angle is two radians.
  static double for_g2o(const Matrix6d& information, int row, int col) {
    const double scale = (row >= 3 ? 2 : 1) * (col >= 3 ? 2 : 1);
    return scale * information((row + 3) % 6, (col + 3) % 6);
  }

  const GraphIndex& index_;
  const std::vector<ChainId>& chains_;
  std::string text_;
};

}  // namespace

std::string to_g2o(const PoseGraph& graph, const GraphSolution& solution) {
  if (solution.components.empty()) return std::string(kHead);
  const GraphIndex index = index_of(graph, graph.config().link_noise);
  const GraphComponent& map = solution.components.front();
  Writer writer(index, map.chains);
  const auto in_map = [&](std::size_t anchor) {
    const SolvedAnchor* solved = solution.find(index.ids[anchor]);
    return solved != nullptr && solved->component == 0;
  };
  for (const SolvedAnchor& anchor : solution.anchors)
    if (anchor.component == 0) writer.vertex(anchor);
  writer.fix(map.reference);
  for (std::size_t i = 0; i < index.ids.size(); ++i)
    if (i != index.first_of_chain(i) && in_map(i) && in_map(i - 1)) writer.edge(odometry_edge(index, i));
  for (const IndexedLink& link : index.links) {
    const LinkVerdict* verdict = solution.find(link.id);
    const bool used = verdict != nullptr && verdict->use == LinkUse::used && link.has_anchors;
    if (used && in_map(link.edge.a) && in_map(link.edge.b)) writer.edge(link.edge);
  }
  return writer.take();
}

}  // namespace onemap::mapping
