// What is counted and looked at beside the work: steps' times, depth, links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/depth_sense.hpp"
#include "daemon/link_tally.hpp"
#include "daemon/step_times.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using mapping::Step;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(StepTimes, AddsUpPiecesOfAStepWithinAFrame) {
  StepTimes times;
  for (int frame = 0; frame < 10; ++frame) {
    times.begin(Step::match, 0ms);
    times.begin(Step::icp, 2ms);
    times.begin(Step::match, 3ms);  // with another keyframe
    times.begin(Step::count, 7ms);
    times.end_frame(8ms);
  }
  const FrameCosts costs = times.costs();
  const Cost& match = costs.steps[static_cast<std::size_t>(Step::match)];
  EXPECT_EQ(match.count, 10u);
  EXPECT_NEAR(match.total_ms, 60, 1e-6);
  EXPECT_NEAR(match.quantiles.p50_ms, 6, 0.051);
  EXPECT_NEAR(costs.steps[static_cast<std::size_t>(Step::icp)].total_ms, 10, 1e-6);
  EXPECT_EQ(costs.steps[static_cast<std::size_t>(Step::ransac)].count, 0u);
  EXPECT_NEAR(costs.frame.quantiles.p99_ms, 8, 0.051);
}

struct Image {
  hal::Intrinsics k;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint16_t> scratch;
  Image(std::uint8_t grey, std::uint16_t nearest, std::uint16_t farthest)
      : rgb(static_cast<std::size_t>(k.width * k.height) * 3, grey), depth(rgb.size() / 3) {
    for (std::size_t i = 0; i < depth.size(); ++i)
      depth[i] = static_cast<std::uint16_t>(nearest + i * (farthest - nearest) / depth.size());
  }
  DepthLook look() {
    hal::FrameView view;
    view.intrinsics = &k;
    view.rgb = rgb;
    view.depth = depth;
    return look_at(view, scratch);
  }
};

TEST(DepthSense, SeesARoomAndDoubtsNothing) {
  Image room(100, 5000, 15000);  // 1 to 3 m
  const DepthLook look = room.look();
  EXPECT_EQ(look.valid, 1);
  EXPECT_NEAR(look.median_m, 2, 0.04);
  EXPECT_NEAR(look.near_m, 1.1, 0.04);
  EXPECT_NEAR(look.far_m, 2.9, 0.04);
  EXPECT_NEAR(look.brightness, 100 / 255.0, 1e-6);
  EXPECT_THAT(doubts(look), IsEmpty());
  EXPECT_THAT(doubts(room.k), IsEmpty());
}

TEST(DepthSense, DoubtsWhatNoRoomLooksLike) {
  Image millimetres(100, 500, 900);  // 0.5 to 0.9 m in millimetres, read with 5000 a metre
  EXPECT_THAT(doubts(millimetres.look()), ElementsAre(HasSubstr("depth_scale too large")));
  Image far(100, 50000, 65000);
  far.k.depth_scale = 1000;
  EXPECT_THAT(doubts(far.look()), ElementsAre(HasSubstr("depth_scale too small")));
  EXPECT_THAT(doubts(Image(0, 5000, 9000).look()), ElementsAre(HasSubstr("black")));
  EXPECT_THAT(doubts(Image(255, 5000, 9000).look()), ElementsAre(HasSubstr("white")));
  EXPECT_THAT(doubts(Image(100, 0, 0).look()), ElementsAre(HasSubstr("no depth")));
  EXPECT_THAT(doubts(Image(100, 9000, 9000).look()), ElementsAre(HasSubstr("same depth")));
}

TEST(DepthSense, DoubtsACalibrationOfAnotherImage) {
  hal::Intrinsics k;
  k.width = 1280;
  k.height = 960;
  EXPECT_THAT(doubts(k), ElementsAre(HasSubstr("principal point")));
  k = {};
  k.fy = 400;
  EXPECT_THAT(doubts(k), ElementsAre(HasSubstr("differ by")));
  k = {};
  k.fx = k.fy = 100;
  EXPECT_THAT(doubts(k), ElementsAre(HasSubstr("field of view")));
}

TEST(LinkTally, CountsByReasonAndOwnLoopsApart) {
  LinkTally tally;
  mapping::LinkLooked looked;
  looked.author = {RobotId::from_name("a"), 1};
  looked.link.a = RobotId::from_name("a");
  looked.link.b = RobotId::from_name("b");
  tally.add(looked);
  looked.link.reason = mapping::LinkReason::inconsistent;
  tally.add(looked);
  looked.link.b = looked.link.a;
  looked.link.incarnation_other = 1;
  looked.link.pairs.resize(1);
  tally.add(looked);
  tally.add(mapping::MapFused{});
  EXPECT_EQ(tally.proposed(), 2u);
  EXPECT_EQ(tally.looked[0], 1u);
  EXPECT_EQ(tally.looked[6], 1u);
  EXPECT_EQ(tally.own_loops, 1u);
  EXPECT_EQ(tally.maps_fused, 1u);
  EXPECT_EQ(LinkTally::reason(6), "inconsistent");
}

}  // namespace
}  // namespace onemap::daemon
