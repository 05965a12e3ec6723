// What the daemon can say about its own troubles, each with what to do.
#include <fmt/format.h>

#include <cmath>

#include "daemon/control/replies.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using control::Json;

namespace {
constexpr std::uint64_t kLittleDisk = 512u << 20;
constexpr std::uint64_t kFewFrames = 30;
constexpr double kClocksApart_s = 0.5;  // an unset clock is hours away, one that is kept at all some milliseconds

struct Findings {
  Json list = Json::array();
  void good(const char* about, const std::string& text) {
    list.push_back({{"about", about}, {"ok", true}, {"text", text}, {"advice", ""}});
  }
  void bad(const char* about, const std::string& text, const std::string& advice) {
    list.push_back({{"about", about}, {"ok", false}, {"text", text}, {"advice", advice}});
  }
};

void look_at_camera(const RobotFacts& facts, Findings& found) {
  const std::string what = printable(facts.camera.description);
  if (facts.camera.away)
    return found.bad("camera", "the camera is gone: " + what,
                     "look at its cable and power; the daemon takes it again by itself");
  if (facts.capture.grabbed == 0)
    return found.bad("camera", "no frame came yet from " + what, "is another program using it?");
  found.good("camera", fmt::format("{}, {} frames", what, facts.capture.grabbed));
  if (!facts.camera.limits.empty())
    found.bad("camera", "the camera " + printable(facts.camera.limits), "plug it into a port that is as fast as it is");
  if (facts.capture.bad * 20 > facts.capture.grabbed)
    found.bad("camera", fmt::format("{} frames could not be read", facts.capture.bad),
              "look at the log, the cable, the USB port");
  if (facts.camera.live && facts.capture.dropped * 2 > facts.capture.grabbed)
    found.bad("camera",
              fmt::format("{} of {} frames were dropped: the processor is too slow", facts.capture.dropped,
                          facts.capture.grabbed),
              "a smaller image, fewer features (tracking.*) or fewer other programs");
}

// Frames that no camera should deliver, where they are many.
void look_at_faults(const RobotFacts& facts, Findings& found) {
  const CaptureCounters& c = facts.capture;
  const auto many = [&](std::uint64_t count, const char* what, const char* advice) {
    if (count * 20 > c.grabbed) found.bad("camera", fmt::format("{} of {} frames {}", count, c.grabbed, what), advice);
  };
  many(c.frozen, "were the same as the one before",
       "the camera or its driver hangs: unplug it, or look for a newer driver");
  many(c.black, "were black", "is the lens covered, or the exposure fixed?");
  many(c.saturated, "were white", "is the exposure fixed?");
  many(c.no_depth, "had no depth", "is the emitter covered, or does the sun shine in?");
  many(c.time_back, "came with a time that went back", "the camera's or the recording's stamps are wrong");
  if (!facts.camera.live) return;  // a recording lacks what it lacks
  many(c.missed, "were taken by the camera and not fetched in time", "other programs take the processor");
  many(c.unmatched, "lacked colour or depth of the same time",
       "do both have the same frame rate? A long exposure slows colour down, a narrow USB port either");
}

void look_at_depth(const RobotFacts& facts, Findings& found) {
  if (!facts.pipeline.look) return;
  const DepthLook& look = *facts.pipeline.look;
  const auto wrong = doubts(look);
  for (const std::string& doubt : wrong)
    found.bad("depth", doubt, "see onemapctl cameras, and the camera's calibration");
  if (wrong.empty())
    found.good("depth", fmt::format("{:.0f} % of the pixels, {:.2f} to {:.2f} m, half within {:.2f} m",
                                    100 * look.valid, look.near_m, look.far_m, look.median_m));
}

void look_at_calibration(const RobotFacts& facts, Findings& found) {
  const hal::Intrinsics& k = facts.camera.intrinsics;
  auto wrong = doubts(k);
  if (facts.pipeline.focal.wrong()) wrong.push_back(doubt(facts.pipeline.focal));
  for (const std::string& one : wrong) found.bad("calibration", one, kCalibrate);
  if (wrong.empty())
    found.good("calibration", fmt::format("{} x {}, fx {:.1f}, fy {:.1f}, centre ({:.1f}, {:.1f}), depth_scale {:g}",
                                          k.width, k.height, k.fx, k.fy, k.cx, k.cy, k.depth_scale));
}

// No image alone says how long a metre is, so this is never good or bad of itself: it says what the values rest on.
void look_at_depth_scale(const RobotFacts& facts, Findings& found) {
  const std::string& address = facts.camera.address;
  if (address.starts_with("simulated:")) return found.good("depth scale", "exact: the camera is simulated");
  if (address.find("calibration=") != std::string::npos)
    return found.good("depth scale", "scale and offset are those of the calibration in the camera's address");
  found.good(
      "depth scale",
      fmt::format("{:g} values a metre, as the {} has it; scale and offset were not measured here: `onemapctl "
                  "calibrate RECORDING` measures the offset, and a wall as far away as a tape says tells the scale",
                  facts.camera.intrinsics.depth_scale, facts.camera.live ? "model" : "recording"));
}

void look_at_tracking(const RobotFacts& facts, Findings& found) {
  const DaemonStatus& s = facts.status;
  if (s.frames < kFewFrames) return;
  const double share = static_cast<double>(s.tracked) / static_cast<double>(s.frames);
  const std::string text = fmt::format("{:.0f} % of {} frames placed", 100 * share, s.frames);
  if (share < 0.8)
    found.bad("tracking", text, "move more slowly, with more light; a wrong calibration does this, too");
  else
    found.good("tracking", text);
  if (s.blocks_refused > 0)
    found.bad("map", fmt::format("the local map is full: {} blocks refused", s.blocks_refused),
              "raise map.budget_mb or map.voxel_m");
  if (facts.team.blocks_refused > 0)
    found.bad("map", fmt::format("the global map is full: {} blocks refused", facts.team.blocks_refused),
              "raise map.global_budget_mb");
}

void look_at_clock(const RobotFacts& facts, Findings& found) {
  const auto backwards = facts.pipeline.not_placed[static_cast<std::size_t>(mapping::TrackReason::time_not_increasing)];
  if (backwards > 0)
    found.bad("clock", fmt::format("{} frames came with a time that is not later than the one before", backwards),
              "the camera's or the recording's stamps are wrong; such frames are refused");
  else
    found.good("clock", "the camera's time goes forward");
  const comms::ScalarValue& offset = facts.radio.scalars.values[static_cast<std::size_t>(comms::Scalar::clock_offset)];
  if (facts.alone || !offset.known) return;
  const double ahead_s = offset.own - offset.agreed;
  const std::string text = fmt::format("this robot's clock is {:.3f} s {} the team's mean", std::abs(ahead_s),
                                       ahead_s < 0 ? "behind" : "ahead of");
  if (std::abs(ahead_s) > kClocksApart_s)
    found.bad("clock", text + ": where two robots were at one time cannot be told from their trajectories",
              "let all of the team's machines keep time (`timedatectl set-ntp true`, or chrony); `onemapctl consensus` "
              "of each says which is wrong");
  else
    found.good("clock", text);
}

void look_at_place(const RobotFacts& facts, Findings& found) {
  const std::string out = printable(facts.place.out);
  const std::string text = fmt::format("{} MB free at {}", facts.place.disk_free_bytes >> 20, out);
  if (!facts.place.out_writable)
    found.bad("disk", out + " cannot be written to", "give it to the daemon's user, or say another robot.out");
  else if (facts.place.disk_free_bytes < kLittleDisk)
    found.bad("disk", text, "make room, or say another robot.out");
  else
    found.good("disk", text);
}

void look_at_peers(const RobotFacts& facts, Findings& found) {
  if (facts.alone) return found.good("peers", "this robot is alone, as it is configured");
  for (const std::string& peer : facts.radio.peers_never_heard)
    found.bad("peers", "peer " + peer + " was never heard",
              "does it run, is the address right, does a firewall drop UDP?");
  for (const comms::NeighbourStatus& n : facts.radio.neighbours) {
    if (!n.alive)
      found.bad("peers", n.robot.name() + " fell silent", "does it run, and is it within reach?");
    else if (n.loss > 0.5)
      found.bad("peers", fmt::format("{:.0f} % of what {} sends is lost", 100 * n.loss, n.robot.name()),
                "a weak radio link, or too little network.bytes_per_second");
    else
      found.good("peers", fmt::format("{} is heard, {:.0f} % loss", n.robot.name(), 100 * n.loss));
  }
  if (facts.radio.neighbours.empty() && facts.radio.peers_never_heard.empty())
    found.bad("peers", "nobody is heard", "say network.peers or network.group");
  if (!facts.radio.id_also_used_at.empty())
    found.bad("peers", "the id " + facts.id + " is also used at " + facts.radio.id_also_used_at,
              "give one of the two another robot.id");
  if (!facts.radio.store_full.empty()) found.bad("peers", facts.radio.store_full, "raise network.store_budget_mb");
}
}  // namespace

Json doctor_json(const RobotFacts& facts) {
  Findings found;
  for (const auto look : {look_at_camera, look_at_faults, look_at_depth, look_at_calibration, look_at_depth_scale,
                          look_at_tracking, look_at_clock, look_at_place, look_at_peers})
    look(facts, found);
  return {{"findings", std::move(found.list)}};
}

}  // namespace onemap::daemon
