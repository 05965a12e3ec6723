// What a pose graph refuses, and what it waits for.
#include "pose_graph_lines.hpp"

namespace onemap::mapping {
namespace {

using namespace test_lines;

TEST(PoseGraphLimits, RefusesWhatIsMalformedAndCountsIt) {
  PoseGraph graph = two_lines(4);
  const auto refused = [&](const Status& status, const char* why) {
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().text().find(why), std::string::npos) << status.error().text();
  };
  std::vector<ChainAnchor> anchors = line(3);
  anchors[2].keyframe = 1;
  refused(graph.set_chain(chain_id("a"), anchors), "ascending");
  anchors = line(3);
  anchors[1].information(3, 3) = -1;
  refused(graph.set_chain(chain_id("a"), anchors), "positive definite");
  anchors = line(3);
  anchors[1].T_previous_anchor.R *= 2;
  refused(graph.set_chain(chain_id("a"), anchors), "not a motion");
  refused(graph.set_anchor(chain_id("a"), line(3)[2]), "ascending");
  refused(graph.set_link(link("b", 1, "a", 1, {})), "a must be before b");
  GraphLink l = link("a", 1, "b", 1, {});
  l.inliers = 0;
  refused(graph.set_link(l), "no inliers");
  l = link("a", 1, "a", 2, {});
  l.b.anchor = 1;
  refused(graph.set_link(l), "one anchor");
  l = link("a", 1, "b", 1, {});
  l.b.anchor = 2;
  refused(graph.set_link(l), "later anchor");
  anchors = line(3);
  anchors[1].information *= 1e12;
  refused(graph.set_chain(chain_id("a"), anchors), "sigmas");
  EXPECT_EQ(graph.refused(), 9u);
  EXPECT_EQ(graph.anchors(), 40u);
  EXPECT_EQ(graph.links().size(), 4u);
}

TEST(PoseGraphLimits, IsBounded) {
  PoseGraphConfig config;
  config.max_anchors = 45;
  config.max_links = 5;
  PoseGraph graph = two_lines(5, config);
  EXPECT_FALSE(graph.set_chain(chain_id("c"), line(6)).ok());
  EXPECT_TRUE(graph.set_chain(chain_id("c"), line(5)).ok());
  ChainAnchor more = line(6)[5];
  EXPECT_FALSE(graph.set_anchor(chain_id("c"), more).ok());
  EXPECT_FALSE(graph.set_link(link("a", 1, "b", 1, {})).ok());
  EXPECT_TRUE(graph.set_link(link("a", 0, "b", 0, shift(0, 3))).ok()) << "replacing is no growth";
  EXPECT_EQ(graph.refused(), 3u);
}

TEST(PoseGraphLimits, LinksWaitForTheirAnchors) {
  PoseGraph graph;
  ASSERT_TRUE(graph.set_link(link("a", 1, "b", 1, {})));
  EXPECT_EQ(graph.solve().links.at(0).use, LinkUse::no_anchor);
  ASSERT_TRUE(graph.set_chain(chain_id("a"), line(3)));
  ASSERT_TRUE(graph.set_chain(chain_id("b"), line(3)));
  EXPECT_EQ(graph.solve().links.at(0).use, LinkUse::chains_apart);
}

}  // namespace
}  // namespace onemap::mapping
