#include "daemon/control/metrics.hpp"

#include <algorithm>
#include <array>

#include "daemon/control/prometheus_text.hpp"
#include "daemon/report.hpp"
#include "mapping/local/track_reason.hpp"

namespace onemap::daemon {

namespace {

using Type = PrometheusText::Type;

double count(std::uint64_t value) { return static_cast<double>(value); }

// A word of ours as Prometheus likes it.
std::string label(std::string_view words) {
  std::string out(words);
  std::ranges::replace(out, ' ', '_');
  return out;
}

void add_robot(const RobotFacts& f, PrometheusText& out) {
  out.family("onemap_info", Type::gauge, "This robot; the value is always 1.");
  out.sample({{"robot", f.id}, {"version", f.version}}, 1);
  out.one("onemap_uptime_seconds", Type::gauge, "Seconds since the daemon was started.", f.uptime_s);
  out.one("onemap_life", Type::gauge, "Number of this robot's present life.", count(f.life));
  out.one("onemap_resident_memory_bytes", Type::gauge, "Resident memory of the daemon.", f.rss_mb * 1048576);
  out.one("onemap_resident_memory_max_bytes", Type::gauge, "The most that it ever was.", f.peak_rss_mb * 1048576);
  out.one("onemap_disk_free_bytes", Type::gauge, "Free where the daemon writes.", count(f.place.disk_free_bytes));
}

void add_cost(const Cost& cost, std::string_view step, PrometheusText& out) {
  const std::array<std::pair<std::string_view, double>, 3> quantiles{
      {{"0.5", cost.quantiles.p50_ms}, {"0.95", cost.quantiles.p95_ms}, {"0.99", cost.quantiles.p99_ms}}};
  for (const auto& [q, ms] : quantiles) out.sample({{"step", step}, {"quantile", q}}, ms);
  out.sample("_sum", {{"step", step}}, cost.total_ms);
  out.sample("_count", {{"step", step}}, count(cost.count));
}

void add_frames(const RobotFacts& f, PrometheusText& out) {
  out.family("onemap_frame_milliseconds", Type::summary,
             "Processor time of frames by step, since the start; step \"all\" is the whole frame.");
  add_cost(f.pipeline.costs.frame, "all", out);
  for (std::size_t i = 0; i < mapping::kSteps; ++i)
    add_cost(f.pipeline.costs.steps[i], label(mapping::to_string(static_cast<mapping::Step>(i))), out);
  out.family("onemap_frames_total", Type::counter, "Frames by what became of them.");
  out.sample({{"outcome", "grabbed"}}, count(f.capture.grabbed));
  out.sample({{"outcome", "bad"}}, count(f.capture.bad));
  out.sample({{"outcome", "dropped"}}, count(f.capture.dropped));
  out.sample({{"outcome", "missed"}}, count(f.capture.missed));
  out.sample({{"outcome", "processed"}}, count(f.status.frames));
  out.sample({{"outcome", "placed"}}, count(f.status.tracked));
  out.one("onemap_images_unmatched_total", Type::counter, "Colour or depth images without a partner in time.",
          count(f.capture.unmatched));
  out.family("onemap_frames_faulty_total", Type::counter, "Frames that no camera should deliver, by what is wrong.");
  out.sample({{"fault", "frozen"}}, count(f.capture.frozen));
  out.sample({{"fault", "black"}}, count(f.capture.black));
  out.sample({{"fault", "saturated"}}, count(f.capture.saturated));
  out.sample({{"fault", "no_depth"}}, count(f.capture.no_depth));
  out.sample({{"fault", "time_back"}}, count(f.capture.time_back));
  out.family("onemap_frames_not_placed_total", Type::counter, "Frames that could not be placed, by the first reason.");
  for (std::size_t i = 1; i < f.pipeline.not_placed.size(); ++i)
    out.sample({{"reason", label(mapping::to_string(static_cast<mapping::TrackReason>(i)))}},
               count(f.pipeline.not_placed[i]));
}

void add_tracking(const RobotFacts& f, PrometheusText& out) {
  out.one("onemap_tracking", Type::gauge, "1 while the camera is tracked, 0 while it is lost.",
          f.status.tracking ? 1 : 0);
  out.one("onemap_in_map", Type::gauge, "1 while this robot knows where it is in the global map.",
          f.status.T_map_odom ? 1 : 0);
  out.one("onemap_times_lost_total", Type::counter, "Times that tracking was lost.", count(f.pipeline.times_lost));
  out.one("onemap_relocalized_total", Type::counter, "Times that it was found again.", count(f.pipeline.relocalized));
  out.one("onemap_chains_total", Type::counter, "Maps of its own that this robot began because it was lost.",
          count(f.pipeline.chains_ended));
  out.one("onemap_keyframes", Type::gauge, "Keyframes in the local map.", count(f.status.keyframes));
  out.one("onemap_camera_up", Type::gauge, "1 while the camera is there.", f.camera.away ? 0 : 1);
  out.one("onemap_camera_gone_total", Type::counter, "Times that the camera went away.", count(f.capture.gone));
  if (!f.pipeline.look) return;
  out.one("onemap_depth_valid_ratio", Type::gauge, "Share of the pixels with depth.", f.pipeline.look->valid);
  out.one("onemap_depth_median_meters", Type::gauge, "Median depth of what is seen.", f.pipeline.look->median_m);
}

void add_map(const RobotFacts& f, PrometheusText& out) {
  out.family("onemap_map_blocks", Type::gauge, "Blocks of 8 x 8 x 8 voxels in use.");
  out.sample({{"map", "local"}}, count(f.pipeline.blocks));
  out.sample({{"map", "global"}}, count(f.team.blocks));
  out.family("onemap_map_blocks_budget", Type::gauge, "Blocks that the budget holds.");
  out.sample({{"map", "local"}}, count(f.local_blocks_most));
  out.sample({{"map", "global"}}, count(f.global_blocks_most));
  out.family("onemap_map_blocks_refused_total", Type::counter, "Blocks that found no room (global: of the last map).");
  out.sample({{"map", "local"}}, count(f.status.blocks_refused));
  out.sample({{"map", "global"}}, count(f.team.blocks_refused));
  out.family("onemap_map_digest_info", Type::gauge, "Digest of the global map as a label; the value is always 1.");
  out.sample({{"digest", digest_text(f.status.map_digest)}}, 1);
  out.one("onemap_map_agreed", Type::gauge, "1 while every robot that counts holds the same map.",
          f.status.map_agreed ? 1 : 0);
  out.one("onemap_place_keyframes_left_out", Type::gauge, "Own keyframes that the thinned place index does not hold.",
          count(f.team.places_left_out));
  out.one("onemap_submaps_needless_total", Type::counter, "Own voxel records that later ones made needless.",
          count(f.team.needless));
  out.one("onemap_keyframes_needless_total", Type::counter, "Own keyframes of which only the places are needed.",
          count(f.team.needless_keyframes));
  out.one("onemap_bodies_let_go_total", Type::counter, "Bodies of replaced records that were given up.",
          count(f.radio.let_go));
  out.one("onemap_exchange_memory_bytes", Type::gauge, "Used of the block in which the exchange lives.",
          static_cast<double>(f.radio.memory.used));
  out.one("onemap_exchange_memory_capacity_bytes", Type::gauge, "Size of that block, which is taken at the start.",
          static_cast<double>(f.radio.memory.capacity));
  out.one("onemap_exchange_memory_spilled_total", Type::counter, "Pieces that did not fit there: the heap gave them.",
          count(f.radio.memory.spilled));
  out.one("onemap_maps_fused_total", Type::counter, "Global maps that were fused.", count(f.links.maps_fused));
  out.one("onemap_merge_seconds", Type::gauge, "From the end of the last robot's work to the map.",
          to_seconds(f.team.merge));
  out.family("onemap_robots", Type::gauge, "Robots by what is known of them.");
  out.sample({{"state", "known"}}, count(f.status.robots_known));
  out.sample({{"state", "in_map"}}, count(f.status.robots_in_map));
  out.sample({{"state", "finished"}}, count(f.status.robots_finished));
  out.sample({{"state", "gone"}}, count(f.team.gone.size()));
}

void add_links(const RobotFacts& f, PrometheusText& out) {
  out.one("onemap_links_proposed_total", Type::counter, "Pairs of robots that somebody looked at.",
          count(f.links.proposed()));
  out.one("onemap_links_accepted_total", Type::counter, "Of them, those that were linked.", count(f.links.looked[0]));
  out.family("onemap_links_refused_total", Type::counter, "Of them, those that were refused, by reason.");
  for (std::size_t i = 1; i < LinkTally::kReasons; ++i)
    out.sample({{"reason", LinkTally::reason(i)}}, count(f.links.looked[i]));
  out.one("onemap_own_loops_total", Type::counter, "Words of robots about places that they came back to.",
          count(f.links.own_loops));
}

void add_peers(const RobotFacts& f, PrometheusText& out) {
  const auto each = [&](std::string_view name, Type type, std::string_view help, const auto& value) {
    out.family(name, type, help);
    for (const comms::NeighbourStatus& n : f.radio.neighbours) out.sample({{"peer", n.robot.name()}}, value(n));
  };
  using N = const comms::NeighbourStatus&;
  each("onemap_peer_up", Type::gauge, "1 while the peer is heard.", [](N n) { return n.alive ? 1.0 : 0.0; });
  each("onemap_peer_loss_ratio", Type::gauge, "Share of datagrams lost on the way from the peer.",
       [](N n) { return n.loss; });
  each("onemap_peer_round_trip_seconds", Type::gauge, "Smoothed round trip; 0: not measured.",
       [](N n) { return to_seconds(n.round_trip); });
  each("onemap_peer_rate_bytes_per_second", Type::gauge, "How fast data may go to the peer.",
       [](N n) { return n.rate; });
  each("onemap_peer_queue_seconds", Type::gauge, "How long data waits on the way to the peer.",
       [](N n) { return to_seconds(n.queue); });
  each("onemap_peer_loss_there_ratio", Type::gauge, "Share of datagrams lost on the way to the peer.",
       [](N n) { return n.loss_there; });
  each("onemap_peer_within_budget", Type::gauge, "0 while the link's budget is used up: only control and poses go.",
       [](N n) { return n.within_budget ? 1.0 : 0.0; });
  each("onemap_peer_same_map", Type::gauge, "1 while the peer says that it holds this robot's map.",
       [&](N n) { return n.map_digest != 0 && n.map_digest == f.status.map_digest ? 1.0 : 0.0; });
  out.family("onemap_peer_bytes_total", Type::counter, "UDP payload by peer and direction.");
  for (const comms::NeighbourStatus& n : f.radio.neighbours) {
    out.sample({{"peer", n.robot.name()}, {"direction", "in"}}, count(n.bytes_in));
    out.sample({{"peer", n.robot.name()}, {"direction", "out"}}, count(n.bytes_out));
  }
}

// Every byte by peer, kind and direction; DATA by lane.
void add_traffic(const RobotFacts& f, PrometheusText& out) {
  static constexpr std::array<std::string_view, kLaneCount> kLanes{"control", "poses", "features", "voxels", "imagery"};
  out.family("onemap_peer_bytes_by_kind_total", Type::counter,
             "UDP payload by peer, direction and kind; headers: of datagrams, and what is not known.");
  for (const comms::NeighbourStatus& n : f.radio.neighbours)
    for (const bool in : {true, false}) {
      const comms::Traffic::Way& way = in ? n.traffic.in : n.traffic.out;
      const auto sample = [&](std::string_view kind, std::uint64_t bytes) {
        if (bytes > 0)
          out.sample({{"peer", n.robot.name()}, {"direction", in ? "in" : "out"}, {"kind", kind}}, count(bytes));
      };
      sample("headers", way.frames[0]);
      for (const comms::FrameType type : comms::kFrameTypes) sample(name(type), way.frames[index_of(type)]);
      for (std::size_t lane = 0; lane < kLaneCount; ++lane) sample(kLanes[lane], way.data[lane]);
    }
}

void add_network(const RobotFacts& f, PrometheusText& out) {
  const comms::Counters& c = f.radio.counters;
  out.family("onemap_bytes_total", Type::counter, "UDP payload, everything included.");
  out.sample({{"direction", "in"}}, count(f.radio.bytes_received));
  out.sample({{"direction", "out"}}, count(f.radio.bytes_sent));
  out.family("onemap_datagrams_total", Type::counter, "Datagrams of this life.");
  out.sample({{"direction", "in"}}, count(c.datagrams_received));
  out.sample({{"direction", "out"}}, count(c.datagrams_sent));
  out.family("onemap_frames_on_wire_total", Type::counter, "Frames of the protocol by kind.");
  for (const auto type : comms::kFrameTypes) {
    out.sample({{"kind", name(type)}, {"direction", "in"}}, count(c.received(type)));
    out.sample({{"kind", name(type)}, {"direction", "out"}}, count(c.sent(type)));
  }
  out.family("onemap_body_bytes_total", Type::counter, "Bytes of record bodies on the wire.");
  out.sample({{"kind", "sent"}}, count(c.body_bytes_sent));
  out.sample({{"kind", "received"}}, count(c.body_bytes_received));
  out.sample({{"kind", "duplicate"}}, count(c.duplicate_body_bytes));
  out.one("onemap_fragments_reasked_total", Type::counter, "Fragments asked for again after a loss.",
          count(c.fragments_reasked));
  out.one("onemap_neighbours_lost_total", Type::counter, "Neighbours that fell silent.", count(c.neighbours_lost));
  out.one("onemap_records_missing", Type::gauge, "Records that neighbours hold and this robot does not, yet.",
          count(f.radio.records_missing));
}

void add_records(const RobotFacts& f, PrometheusText& out) {
  static constexpr std::array<std::string_view, RecordTally::kKinds> kKinds{
      "unknown", "hello", "keyframe", "trajectory", "submap", "link", "solution", "finished", "frontier", "ruling"};
  const auto each = [&](std::string_view name, std::string_view help, auto member) {
    out.family(name, Type::counter, help);
    for (const auto& [robot, tally] : f.radio.records)
      for (std::size_t kind = 0; kind < kKinds.size(); ++kind)
        if (tally.records[kind] > 0)
          out.sample({{"robot", robot.name()}, {"kind", kKinds[kind]}}, count((tally.*member)[kind]));
  };
  each("onemap_records_total", "Records held, by author and kind.", &RecordTally::records);
  each("onemap_record_bytes_total", "Their bodies' bytes.", &RecordTally::bytes);
}

void add_refusals(const RobotFacts& f, PrometheusText& out) {
  out.family("onemap_refused_total", Type::counter, "Datagrams, parts of them, records and blocks refused, by reason.");
  for (const auto& [reason, times] : f.status.refused) out.sample({{"reason", reason}}, count(times));
}

void add_outputs(const RobotFacts& f, PrometheusText& out) {
  out.one("onemap_recording", Type::gauge, "1 while the camera is recorded.", f.recorder.recording ? 1 : 0);
  out.one("onemap_recording_frames", Type::gauge, "Frames in this recording, or in the last one.",
          count(f.recorder.frames));
  out.one("onemap_recording_frames_dropped", Type::gauge, "Frames that came faster than the disk takes them.",
          count(f.recorder.dropped));
  out.family("onemap_snapshots_total", Type::counter, "Snapshots by what became of them.");
  out.sample({{"outcome", "made"}}, count(f.snapshots.made));
  out.sample({{"outcome", "failed"}}, count(f.snapshots.failed));
  out.sample({{"outcome", "left_out"}}, count(f.snapshots.coalesced));
}

void add_control(const RobotFacts& f, PrometheusText& out) {
  out.one("onemap_control_clients", Type::gauge, "Clients of the control socket now.", count(f.control_clients));
  out.one("onemap_control_clients_total", Type::counter, "Clients that ever came.", count(f.control.accepted));
  out.one("onemap_control_requests_total", Type::counter, "Lines from clients.", count(f.control.requests));
  out.family("onemap_control_clients_dropped_total", Type::counter, "Clients that were dropped, by reason.");
  for (const auto& [reason, times] : f.control.dropped) out.sample({{"reason", reason}}, count(times));
  out.family("onemap_control_errors_total", Type::counter, "Requests that were answered with ERROR, by reason.");
  for (const auto& [reason, times] : f.control.errors) out.sample({{"reason", reason}}, count(times));
}

}  // namespace

std::string metrics_text(const RobotFacts& facts) {
  PrometheusText out;
  for (const auto add : {add_robot, add_frames, add_tracking, add_map, add_links, add_peers, add_traffic, add_network,
                         add_records, add_refusals, add_outputs, add_control})
    add(facts, out);
  return out.take();
}

}  // namespace onemap::daemon
