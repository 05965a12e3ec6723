#include "mapping/team/pose_graph_g2o.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <sstream>

#include "pose_graph_team.hpp"
#include "support/other_program.hpp"
#include "support/temp_folder.hpp"
#include "team/pose_graph/graph_index.hpp"

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

// Of odometry and the links in use, at the solved poses: what their information, which is of radians, makes of the
// distances.
double chi2_in_radians(const PoseGraph& graph, const GraphSolution& solution) {
  const GraphIndex index = index_of(graph, graph.config().link_noise);
  const auto pose_of = [&](std::size_t anchor) {
    return from_quantized(solution.find(index.ids[anchor])->T_map_anchor);
  };
  double sum = 0;
  const auto add = [&](const GraphEdge& edge) {
    const Pose E = edge.T_a_b.inverse() * pose_of(edge.a).inverse() * pose_of(edge.b);
    const Eigen::AngleAxisd turn(E.R);
    Vector6d error;
    error << turn.angle() * turn.axis(), E.t;
    sum += error.dot(edge.information * error);
  };
  for (std::size_t i = 0; i < index.ids.size(); ++i)
    if (i != index.first_of_chain(i)) add(odometry_edge(index, i));
  for (const IndexedLink& link : index.links)
    if (solution.find(link.id)->use == LinkUse::used) add(link.edge);
  return sum;
}

struct Written {
  PoseGraph graph;
  GraphSolution solution;
  std::string text;
};
Written three_robots() {
  test::PoseGraphTeam team(3);
  team.add_right_links(40);
  Written out{team.graph(), {}, {}};
  out.solution = out.graph.solve();
  out.text = to_g2o(out.graph, out.solution);
  return out;
}

// What a Python program that is given the file says behind "read ".
std::istringstream read_by(const std::string& python, const std::string& program, const std::string& text) {
  const test::TempFolder folder;
  folder.write("map.g2o", text);
  const test::Said said = test::say(python + " -c '" + program + "' " + (folder / "map.g2o"));
  const std::size_t at = said.output.find("read ");
  EXPECT_TRUE(said.status == 0 && at != std::string::npos) << said.output;
  return std::istringstream(at == std::string::npos ? "" : said.output.substr(at + 5));
}

TEST(PoseGraphG2o, GraphslamSeesTheSameErrors) {
  const std::string python = test::python_with("graphslam.graph");
  if (python.empty()) GTEST_SKIP() << "the Python module graphslam is not installed";
  const Written written = three_robots();
  std::istringstream read = read_by(python,
                                    "import sys; from graphslam.graph import Graph; g = Graph.from_g2o(sys.argv[1]); "
                                    "print(\"read\", len(g._vertices), len(g._edges), g.calc_chi2())",
                                    written.text);
  std::size_t vertices = 0, edges = 0;
  double chi2 = 0;
  ASSERT_TRUE(read >> vertices >> edges >> chi2) << read.str();
  EXPECT_EQ(vertices, 180u);
  EXPECT_EQ(edges, parse(written.text).edges.size());
  const double should = chi2_in_radians(written.graph, written.solution);
  EXPECT_GT(should, 10);
  EXPECT_NEAR(chi2, should, 1e-3 * should) << "its rotation error is the quaternion's vector part, as g2o's is";
}

TEST(PoseGraphG2o, GtsamReadsVerticesAndEdges) {
  const std::string python = test::python_with("gtsam");
  if (python.empty()) GTEST_SKIP() << "the Python module gtsam is not installed";
  const Written written = three_robots();
  std::istringstream read = read_by(python,
                                    "import sys, gtsam; g, v = gtsam.readG2o(sys.argv[1], True); "
                                    "print(\"read\", v.size(), g.size(), *v.atPose3(2097211).translation())",
                                    written.text);
  std::size_t vertices = 0, edges = 0;
  Vector3d t;
  ASSERT_TRUE(read >> vertices >> edges >> t.x() >> t.y() >> t.z()) << read.str();
  const Parsed parsed = parse(written.text);
  EXPECT_EQ(vertices, parsed.vertices.size());
  EXPECT_EQ(edges, parsed.edges.size());
  EXPECT_LT((t - parsed.vertices.at((2 << 20) + 59).t).norm(), 1e-6);
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
