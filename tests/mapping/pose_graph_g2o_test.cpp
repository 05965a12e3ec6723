#include "mapping/team/pose_graph_g2o.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <sstream>

#include "pose_graph_team.hpp"

namespace onemap::mapping {
namespace {

struct Parsed {
  std::map<long, Pose> vertices;
  struct Edge {
    long a, b;
    Pose T_a_b;
    std::vector<double> upper;
  };
  std::vector<Edge> edges;
  std::vector<long> fixed;
  std::string comments;
};

Pose read_pose(std::istream& in) {
  Pose pose;
  std::array<double, 4> q{};
  in >> pose.t.x() >> pose.t.y() >> pose.t.z() >> q[1] >> q[2] >> q[3] >> q[0];
  pose.R = from_quaternion_wxyz(q);
  return pose;
}

Parsed parse(const std::string& text) {
  Parsed out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream in(line);
    std::string tag;
    in >> tag;
    if (tag == "VERTEX_SE3:QUAT") {
      long id = -1;
      in >> id;
      out.vertices[id] = read_pose(in);
    } else if (tag == "FIX") {
      in >> out.fixed.emplace_back();
    } else if (tag == "EDGE_SE3:QUAT") {
      Parsed::Edge edge{};
      in >> edge.a >> edge.b;
      edge.T_a_b = read_pose(in);
      for (double x; in >> x;) edge.upper.push_back(x);
      out.edges.push_back(edge);
    } else {
      EXPECT_EQ(tag, "#") << line;
      out.comments += line + "\n";
    }
  }
  return out;
}

TEST(PoseGraphG2o, WritesTheMapAsG2oReadsIt) {
  test::PoseGraphTeam team(3);
  team.add_right_links(40);
  team.add_random_wrong_links(40);
  const PoseGraph graph = team.graph();
  const GraphSolution solution = graph.solve();
  const Parsed text = parse(to_g2o(graph, solution));
  EXPECT_EQ(text.vertices.size(), 180u);
  EXPECT_EQ(text.edges.size(),
            3 * 59u + static_cast<std::size_t>(team.used(solution, true) + team.used(solution, false)));
  ASSERT_EQ(text.fixed.size(), 1u);
  EXPECT_TRUE(text.vertices.contains(text.fixed[0]));
  EXPECT_TRUE(text.vertices.contains((2 << 20) + 59)) << "chain number << 20 | keyframe";
  EXPECT_NE(text.comments.find("chain 1: b life 1"), std::string::npos);
  EXPECT_NE(text.comments.find("times 4"), std::string::npos);
  for (const Parsed::Edge& edge : text.edges) {
    const Pose E = edge.T_a_b.inverse() * text.vertices.at(edge.a).inverse() * text.vertices.at(edge.b);
    EXPECT_LT(E.t.norm(), 0.15) << edge.a << " " << edge.b;
    EXPECT_EQ(edge.upper.size(), 21u);
  }
}

TEST(PoseGraphG2o, InformationIsTranslationFirstAndOfHalfTheAngle) {
  PoseGraph graph;
  std::vector<ChainAnchor> anchors(2);
  anchors[1].keyframe = 1;
  anchors[1].information = information_of(0.1, 0.5);  // 100 a squared radian, 4 a squared metre
  anchors[1].information(0, 4) = anchors[1].information(4, 0) = 3;
  ASSERT_TRUE(graph.set_chain({RobotId::from_name("a"), 1}, anchors));
  const Parsed text = parse(to_g2o(graph, graph.solve()));
  ASSERT_EQ(text.edges.size(), 1u);
  const std::vector<double> should{4, 0, 0, 0, 0, 0, 4, 0, 6, 0, 0, 4, 0, 0, 0, 400, 0, 0, 400, 0, 400};
  ASSERT_EQ(text.edges[0].upper.size(), 21u);
  for (std::size_t i = 0; i < 21; ++i) EXPECT_NEAR(text.edges[0].upper[i], should[i], 1e-9) << i;
}

TEST(PoseGraphG2o, LeavesOutWhatIsNotInTheMap) {
  test::PoseGraphTeam team(3);
  const PoseGraph graph = team.graph();
  const Parsed text = parse(to_g2o(graph, graph.solve()));
  EXPECT_EQ(text.vertices.size(), 60u);
  EXPECT_EQ(text.edges.size(), 59u);
  EXPECT_TRUE(parse(to_g2o(PoseGraph{}, {})).vertices.empty());
}

}  // namespace
}  // namespace onemap::mapping
