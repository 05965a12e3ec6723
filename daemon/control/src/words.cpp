#include "control/words.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/found_cameras.hpp"

namespace onemap::control {

namespace {
std::string text(const Json& object, const char* key, const std::string& otherwise = "-") {
  const auto value = object.find(key);
  if (value == object.end() || value->is_null()) return otherwise;
  return value->is_string() ? value->get<std::string>() : value->dump();
}
double number(const Json& object, const char* key) {
  const auto value = object.find(key);
  return value != object.end() && value->is_number() ? value->get<double>() : 0;
}
bool flag(const Json& object, const char* key) {
  const auto value = object.find(key);
  return value != object.end() && value->is_boolean() && value->get<bool>();
}
const char* yes_no(bool value) { return value ? "yes" : "no"; }

// How far away something is in time.
std::string ago(double seconds) {
  if (seconds < 1) return "now";
  return seconds < 120 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60);
}

std::string bytes_text(double bytes) {
  if (bytes < 10e3) return fmt::format("{:.0f} B", bytes);
  return bytes < 10e6 ? fmt::format("{:.0f} kB", bytes / 1e3) : fmt::format("{:.1f} MB", bytes / 1e6);
}

std::string pose_text(const Json& pose) {
  if (!pose.is_array() || pose.size() != 7) return "-";
  std::string out;
  for (std::size_t i = 0; i < 7; ++i)
    out +=
        fmt::format("{}{:.{}f}", i == 0 ? "" : " ", pose[i].is_number() ? pose[i].get<double>() : 0.0, i < 3 ? 3 : 4);
  return out;
}

std::string joined(const Json& list) {
  std::string out;
  if (list.is_array())
    for (const Json& item : list)
      out += (out.empty() ? "" : ", ") + (item.is_string() ? item.get<std::string>() : item.dump());
  return out;
}

std::string counts(const Json& object) {
  std::string out;
  if (object.is_object())
    for (const auto& [name, count] : object.items())
      out += fmt::format("{}{} {}", out.empty() ? "" : ", ", name, count.dump());
  return out.empty() ? "none" : out;
}

const Json& member(const Json& object, const char* key) {
  static const Json kNone;
  const auto value = object.find(key);
  return value == object.end() ? kNone : *value;
}

std::string line(std::string_view name, const std::string& value) {
  return fmt::format("{:<14}{}{}\n", name, name.size() < 14 ? "" : " ", value);
}
}  // namespace

std::string table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i == widths.size()) widths.push_back(0);
      widths[i] = std::max(widths[i], row[i].size());
    }
  std::string out;
  for (const auto& row : rows) {
    std::string text_line;
    for (std::size_t i = 0; i < row.size(); ++i) text_line += fmt::format("{:<{}}  ", row[i], widths[i]);
    text_line.erase(text_line.find_last_not_of(' ') + 1);
    out += text_line + "\n";
  }
  return out;
}

std::string status_words(const Json& a) {
  const Json& pose = member(a, "pose");
  const Json& ms = member(a, "ms_per_frame");
  std::string out =
      line("robot", fmt::format("{} (life {}, up {})", text(a, "robot"), text(a, "life"), ago(number(a, "uptime_s"))));
  out += line("camera", text(a, "camera") + (flag(a, "camera_away") ? " - GONE, waiting for it" : ""));
  out +=
      line("state", fmt::format("{}, {}", text(a, "state"), flag(pose, "tracking") ? "camera tracked" : "camera lost"));
  out += line("frames",
              fmt::format("{} done, {} placed, {} dropped, {} bad, {} missed; {:.1f} ms each (p99 {:.1f})",
                          text(a, "frames"), text(a, "tracked"), text(a, "frames_dropped"), text(a, "frames_bad"),
                          text(a, "frames_missed"), number(ms, "p50"), number(ms, "p99")));
  if (number(a, "images_unmatched") > 0)
    out += line("images", fmt::format("{} without a partner in time", text(a, "images_unmatched")));
  out += line("keyframes", text(a, "keyframes"));
  out += line("map", fmt::format("{}, {} of {} robots in it, {}", text(a, "map_digest"), text(a, "robots_in_map"),
                                 text(a, "robots_known"),
                                 flag(a, "map_agreed") ? "the same everywhere" : "not the same everywhere yet"));
  out += line("in the map at", pose_text(member(pose, "T_map_odom")) == "-" ? "not in the global map"
                                                                            : pose_text(member(pose, "T_map_odom")));
  if (!text(a, "waiting", "").empty())
    out += line("waiting", text(a, "waiting") + (flag(a, "stuck") ? " (cannot come by itself)" : ""));
  out += line("refused", counts(member(a, "refused")));
  return out + line("memory", fmt::format("{:.0f} MB", number(a, "rss_mb")));
}

std::string peers_words(const Json& a) {
  if (flag(a, "alone")) return "this robot is alone: no network.listen, network.peers or network.group\n";
  std::vector<std::vector<std::string>> rows{
      {"PEER", "AT", "HEARD", "LOSS", "LOSS THERE", "ETX", "ROUND TRIP", "RATE", "IN", "OUT", "MAP", "SAME"}};
  for (const Json& p : member(a, "peers"))
    rows.push_back({text(p, "robot"), text(p, "endpoint"),
                    flag(p, "alive") ? ago(number(p, "silent_s")) : "silent " + ago(number(p, "silent_s")),
                    fmt::format("{:.0f} %", 100 * number(p, "loss")),
                    fmt::format("{:.0f} %", 100 * number(p, "loss_there")), fmt::format("{:.2f}", number(p, "etx")),
                    fmt::format("{:.1f} ms", number(p, "round_trip_ms")),
                    !p.contains("within_budget") || flag(p, "within_budget") ? bytes_text(number(p, "rate")) + "/s"
                                                                             : "budget spent",
                    bytes_text(number(p, "bytes_in")), bytes_text(number(p, "bytes_out")), text(p, "map_digest"),
                    yes_no(flag(p, "same_map"))});
  std::string out = table(rows);
  for (const Json& peer : member(a, "never_heard")) out += "never heard: " + peer.get<std::string>() + "\n";
  std::vector<std::vector<std::string>> robots{{"\nROBOT", "SIGN OF LIFE", "RECORDS", "MAP", "SAME"}};
  for (const Json& r : member(a, "robots"))
    robots.push_back({text(r, "robot") + (flag(r, "own") ? " (this one)" : ""),
                      flag(r, "gone") ? "gone, " + ago(number(r, "silent_s")) : ago(number(r, "silent_s")),
                      flag(r, "records_complete") ? "all" : "some missing", text(r, "map_digest"),
                      yes_no(flag(r, "same_map"))});
  out += table(robots);
  if (!text(a, "id_also_used_at", "").empty())
    out += "this robot's id is also used at " + text(a, "id_also_used_at") + "\n";
  return out;
}

std::string consensus_words(const Json& a) {
  if (flag(a, "alone")) return "this robot is alone: there is nobody to agree with\n";
  const auto of = [&](const char* scalar, const char* which) { return member(member(a, scalar), which); };
  const auto shown = [&](const char* scalar, const char* which, int digits) {
    const Json value = of(scalar, which);
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : std::string("not known yet");
  };
  std::string out = line(
      "state", fmt::format("{}, {} exchanges", flag(a, "settled") ? "settled" : "under way", text(a, "exchanges")));
  out += line("robots", shown("team_size", "agreed", 2));
  out += line("clock", shown("clock_offset_s", "own", 4) + " s ahead of the team's mean");
  out += line("brightness", shown("brightness", "own", 1) + ", the team's mean " + shown("brightness", "agreed", 1));
  const Json gain = member(a, "colour_gain");
  return out + line("colour gain", gain.is_number() ? fmt::format("{:.3f}", gain.get<double>()) : "not known yet");
}

std::string map_words(const Json& a) {
  const Json& links = member(a, "links");
  std::string out = line("digest", text(a, "digest") + (flag(a, "agreed") ? " (the same everywhere)" : ""));
  if (!joined(member(a, "differs")).empty()) out += line("differs at", joined(member(a, "differs")));
  out += line("robots", fmt::format("{} of {} in it", text(a, "robots_in_map"), text(a, "robots_known")));
  if (!joined(member(a, "gone")).empty()) out += line("gone", joined(member(a, "gone")));
  out += line("global", fmt::format("{} of {} blocks, {} refused", text(a, "blocks"), text(a, "blocks_most"),
                                    text(a, "blocks_refused")));
  out +=
      line("local", fmt::format("{} of {} blocks, {} refused, {} keyframes", text(a, "local_blocks"),
                                text(a, "local_blocks_most"), text(a, "local_blocks_refused"), text(a, "keyframes")));
  out += line("links", fmt::format("{} pairs looked at, {} accepted; refused: {}", text(links, "looked_at"),
                                   text(links, "accepted"), counts(member(links, "refused"))));
  out += line("T_map_odom", pose_text(member(a, "T_map_odom")));
  if (!text(a, "waiting", "").empty()) out += line("waiting", text(a, "waiting"));
  return out;
}

std::string pose_words(const Json& a) {
  const bool in_map = member(a, "T_map_camera").is_array();
  return fmt::format("{:.6f} {} {} {}\n", number(a, "time_s"), flag(a, "tracking") ? "tracked" : "lost",
                     in_map ? "map " : "odom", pose_text(member(a, in_map ? "T_map_camera" : "T_odom_camera")));
}

std::string cameras_words(const Json& a) {
  std::string out;
  for (const Json& c : member(a, "cameras")) {
    const Json& look = member(c, "look");
    out += line("camera", text(c, "address"));
    out += line("is", text(c, "description") + (flag(c, "away") ? " - GONE, waiting for it" : ""));
    if (!text(c, "limits", "").empty()) out += line("limited", text(c, "limits"));
    out += line("images",
                fmt::format("{} x {}, fx {:.2f} fy {:.2f} cx {:.2f} cy {:.2f}", text(c, "width"), text(c, "height"),
                            number(c, "fx"), number(c, "fy"), number(c, "cx"), number(c, "cy")));
    out += line("depth_scale", text(c, "depth_scale"));
    out += line("frames", fmt::format("{} taken, {} bad, {} dropped, {} missed, {} images without a partner; gone {} "
                                      "times",
                                      text(c, "frames"), text(c, "bad"), text(c, "dropped"), text(c, "missed"),
                                      text(c, "unmatched"), text(c, "times_gone")));
    if (look.is_object())
      out +=
          line("sees",
               fmt::format("depth in {:.0f} % of the pixels, {:.2f} to {:.2f} m, median {:.2f} m; brightness {:.0f} %",
                           100 * number(look, "valid"), number(look, "near_m"), number(look, "far_m"),
                           number(look, "median_m"), 100 * number(look, "brightness")));
  }
  if (!out.empty()) out += "\n";
  out += "on this machine:\n";
  if (member(a, "found").is_array()) return out + found_cameras_words(a);
  return out + "cannot be told: " + text(a, "not_found_because") + "\n";
}

std::string findings_words(const Json& findings) {
  std::string out;
  for (const Json& f : findings) {
    out += fmt::format("{}  {:<13}{}\n", flag(f, "ok") ? "ok " : "BAD", text(f, "about"), text(f, "text"));
    if (!flag(f, "ok") && !text(f, "advice", "").empty())
      out += fmt::format("     {:<13}-> {}\n", "", text(f, "advice"));
  }
  return out;
}

std::string why_words(const Json& a) {
  const auto chain = [](const Json& c) { return fmt::format("{} (life {})", text(c, "robot"), text(c, "life")); };
  std::string out = flag(a, "one_map") ? "they are in one map\n" : "they are not in one map\n", way;
  for (const Json& c : member(a, "way")) way += (way.empty() ? "" : " - ") + chain(c);
  if (!way.empty()) out += line("joined over", way);
  for (const Json& p : member(a, "pairs")) {
    const Json &link = member(p, "link"), &ruling = member(p, "ruling");
    out += fmt::format("\n{} and {}: {}\n", chain(member(p, "a")), chain(member(p, "b")), text(p, "verdict"));
    if (link.is_object())
      out += line("  looked at",
                  fmt::format("{}; {} pairs of clouds agree, {} inliers, error {:.1f} mm", text(link, "words"),
                              text(link, "supporting_pairs"), text(link, "inliers"), number(link, "error_mm")));
    if (ruling.is_object())
      out += line("  a person said",
                  fmt::format("{}, at {}", flag(ruling, "apart") ? "they are apart" : "they may be joined",
                              text(ruling, "by")));
    out += line("  its links", fmt::format("{} compared, {} agree, {} in use; {}", text(p, "links"), text(p, "agree"),
                                           text(p, "used"), counts(member(p, "uses"))));
    if (number(p, "worst_sigmas") > 0)
      out += line("  worst in use", fmt::format("{:.1f} sigmas squared", number(p, "worst_sigmas")));
  }
  if (member(a, "pairs").empty())
    out += "nobody has looked at the two yet, or another robot did: ask the one with the lower name\n";
  return out;
}

std::string event_words(const Json& o) {
  const std::string name = text(o, "class", "");
  if (name == "POSE") return pose_words(o);
  if (name == "PEERS")
    return fmt::format("peers: {} neighbours, {} robots\n", member(o, "peers").size(), member(o, "robots").size());
  if (name == "STATUS")
    return fmt::format("status: {}, {} frames, map {}\n", text(o, "state"), text(o, "frames"), text(o, "map_digest"));
  std::string out = name == "EVENT" ? text(o, "event") : name;
  for (const auto& [key, value] : o.items())
    if (key != "class" && key != "event")
      out += fmt::format(" {}={}", key, value.is_string() ? value.get<std::string>() : value.dump());
  return out + "\n";
}

std::string fields_words(const Json& answer) {
  std::string out;
  for (const auto& [key, value] : answer.items())
    if (key != "class" && key != "id" && key != "of")
      out += line(key, value.is_string() ? value.get<std::string>() : value.dump());
  return out;
}

}  // namespace onemap::control
