#include "daemon/control/replies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using control::Json;
using testing::HasSubstr;
using testing::IsEmpty;

RobotFacts healthy() {
  RobotFacts f;
  f.id = "r1";
  f.camera.description = "a camera";
  f.capture.grabbed = 1000;
  f.status.frames = f.status.tracked = 1000;
  f.pipeline.look = DepthLook{0.9, 0.8, 1.5, 3, 0.001, 0.4};
  f.place = {"/o", "/o/control.sock", std::uint64_t{10} << 30, true};
  return f;
}

// What is wrong, a line each: "about: text -> advice".
std::vector<std::string> troubles(const RobotFacts& facts) {
  std::vector<std::string> out;
  const Json answer = doctor_json(facts);
  for (const Json& f : answer.at("findings"))
    if (!f.at("ok").get<bool>())
      out.push_back(f.at("about").get<std::string>() + ": " + f.at("text").get<std::string>() + " -> " +
                    f.at("advice").get<std::string>());
  return out;
}

void expect_only(const RobotFacts& facts, const std::string& about, const std::string& words) {
  const auto found = troubles(facts);
  ASSERT_EQ(found.size(), 1u) << testing::PrintToString(found);
  EXPECT_THAT(found[0], testing::StartsWith(about + ": "));
  EXPECT_THAT(found[0], HasSubstr(words));
  EXPECT_THAT(found[0], testing::Not(testing::EndsWith("-> "))) << "and what to do";
}

TEST(Doctor, SaysOfAHealthyRobotThatItIs) { EXPECT_THAT(troubles(healthy()), IsEmpty()); }

TEST(Doctor, FindsEachTroubleAlone) {
  RobotFacts f = healthy();
  f.camera.away = true;
  expect_only(f, "camera", "is gone");
  f = healthy();
  f.camera.limits = "is on USB 2";
  expect_only(f, "camera", "the camera is on USB 2");
  f = healthy();
  f.capture.frozen = 500;
  expect_only(f, "camera", "500 of 1000 frames were the same");
  f = healthy();
  f.capture.missed = f.capture.unmatched = 200;
  EXPECT_THAT(troubles(f), IsEmpty()) << "a recording lacks what it lacks";
  f.camera.live = true;
  f.capture.unmatched = 0;
  expect_only(f, "camera", "200 of 1000 frames were taken by the camera and not fetched");
  f = healthy();
  f.camera.live = true;
  f.capture.unmatched = 200;
  expect_only(f, "camera", "200 of 1000 frames lacked colour or depth");
  f = healthy();
  f.pipeline.look->median_m = 0.1;
  expect_only(f, "depth", "depth_scale too large");
  f = healthy();
  f.camera.intrinsics.cx = 10;
  expect_only(f, "calibration", "principal point");
  f = healthy();
  f.pipeline.focal = {0.8, 0.01, 20};
  expect_only(f, "calibration", "0.80 of what fits 20 pairs of views");
  f.pipeline.focal.views = 2;
  EXPECT_THAT(troubles(f), IsEmpty()) << "too few to say";
  f = healthy();
  f.status.tracked = 300;
  expect_only(f, "tracking", "30 % of 1000 frames placed");
  f = healthy();
  f.status.blocks_refused = 3;
  expect_only(f, "map", "raise map.budget_mb");
  f = healthy();
  f.place.disk_free_bytes = 1 << 20;
  expect_only(f, "disk", "1 MB free");
  f = healthy();
  f.place.out_writable = false;
  expect_only(f, "disk", "cannot be written to");
  f = healthy();
  f.pipeline.not_placed[static_cast<std::size_t>(mapping::TrackReason::time_not_increasing)] = 2;
  expect_only(f, "clock", "2 frames");
}

TEST(Doctor, FindsTroublesWithPeers) {
  RobotFacts f = healthy();
  f.alone = false;
  expect_only(f, "peers", "nobody is heard");
  f.radio.peers_never_heard = {"10.0.0.2:4600"};
  expect_only(f, "peers", "10.0.0.2:4600 was never heard");
  f.radio.peers_never_heard.clear();
  comms::NeighbourStatus peer;
  peer.robot = RobotId::from_name("r2");
  f.radio.neighbours = {peer};
  expect_only(f, "peers", "r2 fell silent");
  f.radio.neighbours[0].alive = true;
  EXPECT_THAT(troubles(f), IsEmpty());
  f.radio.neighbours[0].loss = 0.8;
  expect_only(f, "peers", "80 %");
  f.radio.neighbours[0].loss = 0;
  f.radio.id_also_used_at = "10.0.0.3:1";
  expect_only(f, "peers", "also used at 10.0.0.3:1");
}

TEST(Doctor, FindsAClockThatIsFarFromTheTeams) {
  RobotFacts f = healthy();
  f.alone = false;
  comms::NeighbourStatus peer;
  peer.robot = RobotId::from_name("r2");
  peer.alive = true;
  f.radio.neighbours = {peer};
  auto& offset = f.radio.scalars.values[static_cast<std::size_t>(comms::Scalar::clock_offset)];
  offset = {1.7e9 - 1800, 1.7e9, false};
  EXPECT_THAT(troubles(f), IsEmpty()) << "not known yet";
  offset.known = true;
  expect_only(f, "clock", "clock is 1800.000 s behind the team's mean");
  expect_only(f, "clock", "timedatectl");
  offset.own = 1.7e9 + 1;
  expect_only(f, "clock", "1.000 s ahead of");
  offset.own = 1.7e9 + 0.02;
  EXPECT_THAT(troubles(f), IsEmpty());
  offset.own = 0;
  f.alone = true;
  EXPECT_THAT(troubles(f), IsEmpty()) << "there is nobody to agree with";
}

// Good or not, it is said on what the scale of depth rests.
TEST(Doctor, SaysWhatTheScaleOfDepthRestsOn) {
  RobotFacts f = healthy();
  const auto said = [&] {
    const Json answer = doctor_json(f);
    for (const Json& one : answer.at("findings"))
      if (one.at("about") == "depth scale") return one.at("text").get<std::string>();
    return std::string("nothing");
  };
  f.camera.live = true;
  f.camera.address = "auto";
  f.camera.intrinsics.depth_scale = 1000;
  EXPECT_THAT(said(), HasSubstr("1000 values a metre, as the model has it; scale and offset were not measured here"));
  EXPECT_THAT(said(), HasSubstr("onemapctl calibrate RECORDING"));
  f.camera.address = "v4l2:/dev/video0?calibration=/etc/onemap/mine.txt";
  EXPECT_THAT(said(), HasSubstr("of the calibration in the camera's address"));
  f.camera.address = "simulated:office";
  EXPECT_THAT(said(), HasSubstr("exact"));
  EXPECT_THAT(troubles(f), IsEmpty());
}

TEST(Replies, TheMapIsKnownOnlyOfTheChainThatIsInIt) {
  TeamView team;
  PoseNow pose;
  EXPECT_FALSE(map_correction(team, pose));
  team.T_map_odometry = mapping::quantize({mapping::Matrix3d::Identity(), {1, 2, 3}});
  ASSERT_TRUE(map_correction(team, pose));
  EXPECT_NEAR(map_correction(team, pose)->t.z(), 3, 1e-4);
  pose.chain = 1;
  EXPECT_FALSE(map_correction(team, pose)) << "it has begun another map since";
}

TEST(Replies, APoseIsGivenInTheMapWhereThatIsKnown) {
  PoseNow pose;
  pose.tracking = true;
  pose.T_odom_camera.t = {1, 0, 0};
  const Json lost = pose_json(pose, std::nullopt);
  EXPECT_TRUE(lost.at("T_map_camera").is_null());
  const Json found = pose_json(pose, mapping::Pose{mapping::Matrix3d::Identity(), {0, 2, 0}});
  EXPECT_EQ(found.at("T_map_camera").dump(), "[1.0,2.0,0.0,0.0,0.0,0.0,1.0]");
}

}  // namespace
}  // namespace onemap::daemon
