#include "daemon/control/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/control/prometheus_text.hpp"
#include "support/prometheus_parser.hpp"

namespace onemap::daemon {
namespace {

using test::PrometheusParser;

RobotFacts busy_robot() {
  RobotFacts f;
  f.id = "r1";
  f.version = "1.2.3";
  f.status.frames = 90;
  f.status.tracked = 80;
  f.status.tracking = true;
  f.status.map_digest = 0xABC;
  f.status.refused = {{"bad_magic", 4}};
  f.capture.grabbed = 100;
  f.capture.bad = 2;
  f.capture.dropped = 8;
  f.capture.gone = 1;
  f.capture.frozen = 6;
  f.capture.unmatched = 9;
  f.capture.missed = 3;
  f.snapshots.made = 7;
  f.rss_mb = 160;
  f.pipeline.costs.frame = {{8, 12, 15}, 800, 90};
  f.pipeline.costs.steps[static_cast<std::size_t>(mapping::Step::features)] = {{2, 3, 4}, 200, 88};
  f.pipeline.not_placed[static_cast<std::size_t>(mapping::TrackReason::too_few_features)] = 10;
  f.pipeline.blocks = 12;
  f.local_blocks_most = 100;
  f.links.looked = {2, 3, 0, 0, 0, 0, 1, 0};
  comms::NeighbourStatus peer;
  peer.robot = RobotId::from_name("r2");
  peer.alive = true;
  peer.loss = 0.25;
  peer.bytes_in = 1000;
  peer.bytes_out = 2000;
  peer.map_digest = 0xABC;
  peer.traffic.in.frames[0] = 40;
  peer.traffic.in.frames[comms::index_of(comms::FrameType::ping)] = 60;
  peer.traffic.out.data[2] = 1500;
  f.radio.neighbours = {peer};
  f.radio.counters.refuse(comms::Refusal::bad_magic);
  RecordTally& tally = f.radio.records[peer.robot];
  tally.records[2] = 3;
  tally.bytes[2] = 3000;
  f.control.dropped["slow"] = 5;
  return f;
}

TEST(Metrics, EveryFamilyParsesStrictlyAndSaysWhatTheFactsSay) {
  const auto families = PrometheusParser::parse(metrics_text(busy_robot()));
  const auto value = [&](const std::string& family, const std::string& labels) {
    return families.at(family).samples.at(family + labels);
  };
  EXPECT_EQ(value("onemap_info", "{robot=r1,version=1.2.3}"), 1);
  EXPECT_EQ(value("onemap_frame_milliseconds", "{step=all,quantile=0.99}"), 15);
  EXPECT_EQ(families.at("onemap_frame_milliseconds").samples.at("onemap_frame_milliseconds_count{step=all}"), 90);
  EXPECT_EQ(value("onemap_frame_milliseconds", "{step=features,quantile=0.95}"), 3);
  EXPECT_EQ(value("onemap_resident_memory_bytes", ""), 160 * 1048576);
  EXPECT_EQ(value("onemap_peer_bytes_by_kind_total", "{peer=r2,direction=in,kind=headers}"), 40);
  EXPECT_EQ(value("onemap_peer_bytes_by_kind_total", "{peer=r2,direction=in,kind=ping}"), 60);
  EXPECT_EQ(value("onemap_peer_bytes_by_kind_total", "{peer=r2,direction=out,kind=features}"), 1500);
  EXPECT_EQ(value("onemap_frames_total", "{outcome=dropped}"), 8);
  EXPECT_EQ(value("onemap_frames_total", "{outcome=missed}"), 3);
  EXPECT_EQ(value("onemap_images_unmatched_total", ""), 9);
  EXPECT_EQ(value("onemap_frames_not_placed_total", "{reason=too_few_features}"), 10);
  EXPECT_EQ(value("onemap_frames_faulty_total", "{fault=frozen}"), 6);
  EXPECT_EQ(value("onemap_snapshots_total", "{outcome=made}"), 7);
  EXPECT_EQ(value("onemap_tracking", ""), 1);
  EXPECT_EQ(value("onemap_map_blocks", "{map=local}"), 12);
  EXPECT_EQ(value("onemap_map_blocks_budget", "{map=local}"), 100);
  EXPECT_EQ(value("onemap_map_digest_info", "{digest=0000000000000abc}"), 1);
  EXPECT_EQ(value("onemap_links_proposed_total", ""), 6);
  EXPECT_EQ(value("onemap_links_accepted_total", ""), 2);
  EXPECT_EQ(value("onemap_links_refused_total", "{reason=too_few_matches}"), 3);
  EXPECT_EQ(value("onemap_links_refused_total", "{reason=inconsistent}"), 1);
  EXPECT_EQ(value("onemap_peer_loss_ratio", "{peer=r2}"), 0.25);
  EXPECT_EQ(value("onemap_peer_bytes_total", "{peer=r2,direction=out}"), 2000);
  EXPECT_EQ(value("onemap_peer_same_map", "{peer=r2}"), 1);
  EXPECT_EQ(value("onemap_record_bytes_total", "{robot=r2,kind=keyframe}"), 3000);
  EXPECT_EQ(value("onemap_refused_total", "{reason=bad_magic}"), 4);
  EXPECT_EQ(value("onemap_control_clients_dropped_total", "{reason=slow}"), 5);
}

TEST(Metrics, ARobotThatHasJustStartedParses) { EXPECT_NO_THROW(PrometheusParser::parse(metrics_text({}))); }

TEST(PrometheusText, EscapesWhatLabelsAndHelpHold) {
  PrometheusText out;
  out.family("x", PrometheusText::Type::gauge, "a \\ b\nc");
  out.sample({{"k", "q\"uo\\te\nline"}}, 0.5);
  out.sample({{"k", "b"}}, std::numeric_limits<double>::infinity());
  const std::string text = out.take();
  EXPECT_EQ(text, "# HELP x a \\\\ b\\nc\n# TYPE x gauge\nx{k=\"q\\\"uo\\\\te\\nline\"} 0.5\nx{k=\"b\"} +Inf\n");
  EXPECT_EQ(PrometheusParser::parse(text).at("x").samples.at("x{k=q\"uo\\te\nline}"), 0.5);
}

TEST(PrometheusParserItself, SeesWhatIsWrong) {
  for (const char* wrong : {"x 1\n", "# HELP x y\n# TYPE x gauge\nx 1", "# HELP x y\n# TYPE x counter\nx 1\n",
                            "# HELP x y\n# TYPE x gauge\nx 1\nx 1\n", "# HELP x y\n# TYPE x gauge\nx{a=\"\\q\"} 1\n",
                            "# HELP x y\n# TYPE x gauge\nx{a=\"1\",a=\"2\"} 1\n", "# HELP x y\n# TYPE x gauge\nx one\n",
                            "# HELP x y\n# TYPE x gauge\ny 1\n"})
    EXPECT_THROW(PrometheusParser::parse(wrong), std::runtime_error) << wrong;
}

}  // namespace
}  // namespace onemap::daemon
